/* Arithmetic of values that share one list of denominator factors. */
#include <assert.h>

#include "arena.h"
#include "bridge.h"
#include "flint_ends.h"
#include "mpoly_take.h"

void poly_ratio_init(const struct poly_bridge *b, struct poly_ratio *r)
{
    *r = (struct poly_ratio){ 0 };
    fmpz_mpoly_init(r->num, b->ctx);
    fmpz_init_set_ui(r->scale, 1);
}

void poly_ratio_clear(const struct poly_bridge *b, struct poly_ratio *r)
{
    fmpz_mpoly_clear(r->num, b->ctx);
    fmpz_clear(r->scale);
}

static void copy_powers(const struct poly_bridge *b, int *to, const int *from)
{
    for (int i = 0; i < b->bases; i++)
        to[i] = from[i];
}

bool poly_ratio_sane(const struct poly_bridge *b, const struct poly_ratio *r)
{
    bool sane = fmpz_sgn(r->scale) > 0;
    for (int i = 0; i < b->bases && sane; i++)
        sane = r->power[i] >= 0;
    return sane;
}

void poly_ratio_set(const struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x)
{
    fmpz_mpoly_set(r->num, x->num, b->ctx);
    fmpz_set(r->scale, x->scale);
    copy_powers(b, r->power, x->power);
}

static void no_powers(const struct poly_bridge *b, struct poly_ratio *r)
{
    for (int i = 0; i < b->bases; i++)
        r->power[i] = 0;
}

void poly_ratio_fmpq(const struct poly_bridge *b, struct poly_ratio *r, const fmpq_t q)
{
    fmpz_mpoly_set_fmpz(r->num, fmpq_numref(q), b->ctx);
    fmpz_set(r->scale, fmpq_denref(q));
    no_powers(b, r);
    assert(fmpz_sgn(r->scale) > 0);
}

void poly_ratio_gen(const struct poly_bridge *b, struct poly_ratio *r, int gen)
{
    assert(gen >= 0 && gen < b->gens);
    fmpz_mpoly_gen(r->num, gen, b->ctx);
    fmpz_one(r->scale);
    no_powers(b, r);
}

/* Common integer factors of numerator and scale. */
static void tidy(struct poly_bridge *b, struct poly_ratio *r)
{
    if (fmpz_mpoly_is_zero(r->num, b->ctx)) {
        fmpz_one(r->scale);
        no_powers(b, r);
    } else if (!fmpz_is_one(r->scale)) {
        SGA_ENDS(fmpz_end) fmpz_t c;
        fmpz_init_set(c, r->scale);
        for (slong i = 0; i < r->num->length && !fmpz_is_one(c); i++)
            fmpz_gcd(c, c, r->num->coeffs + i);
        if (!fmpz_is_one(c)) {
            fmpz_mpoly_scalar_divexact_fmpz(r->num, r->num, c, b->ctx);
            fmpz_divexact(r->scale, r->scale, c);
        }
    }
}

/* Divides f by base[i] as often as that goes, at most *power times. */
static void cancel(struct poly_bridge *b, fmpz_mpoly_t f, int i, int *power)
{
    while (*power > 0 && poly_divides(b, f, f, b->base[i].f))
        --*power;
}

static bool multiply_by_base(struct poly_bridge *b, fmpz_mpoly_t f, int i, int n)
{
    for (; n > 0; n--)
        if (!poly_mul(b, f, f, b->base[i].f))
            return false;
    return true;
}

static bool add_plain(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x,
                      const struct poly_ratio *y, bool subtract)
{
    if (subtract)
        fmpz_mpoly_sub(r->num, x->num, y->num, b->ctx);
    else
        fmpz_mpoly_add(r->num, x->num, y->num, b->ctx);
    return poly_fits(b, r->num);
}

bool poly_ratio_add(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x,
                    const struct poly_ratio *y, bool subtract)
{
    assert(poly_ratio_sane(b, x) && poly_ratio_sane(b, y));
    struct poly_ratio u, v;
    bool ok = true, same = fmpz_equal(x->scale, y->scale);
    for (int i = 0; i < b->bases; i++)
        same = same && x->power[i] == y->power[i];
    if (same) {
        fmpz_set(r->scale, x->scale);
        copy_powers(b, r->power, x->power);
        ok = add_plain(b, r, x, y, subtract);
    } else {
        SGA_ENDS(fmpz_end) fmpz_t g = { 0 };
        poly_ratio_init(b, &u);
        poly_ratio_init(b, &v);
        fmpz_gcd(g, x->scale, y->scale);
        fmpz_divexact(u.scale, y->scale, g);   /* what x is multiplied by */
        fmpz_divexact(v.scale, x->scale, g);
        fmpz_mul(r->scale, x->scale, u.scale);
        fmpz_mpoly_scalar_mul_fmpz(u.num, x->num, u.scale, b->ctx);
        fmpz_mpoly_scalar_mul_fmpz(v.num, y->num, v.scale, b->ctx);
        for (int i = 0; ok && i < b->bases; i++) {
            int more = x->power[i] - y->power[i];
            r->power[i] = more > 0 ? x->power[i] : y->power[i];
            ok = multiply_by_base(b, more > 0 ? v.num : u.num, i, more > 0 ? more : -more);
        }
        ok = ok && add_plain(b, r, &u, &v, subtract);
        poly_ratio_clear(b, &u);
        poly_ratio_clear(b, &v);
    }
    if (!ok)
        return false;
    for (int i = 0; i < b->bases; i++)     /* with unequal powers nothing can cancel */
        if (x->power[i] > 0 && x->power[i] == y->power[i])
            cancel(b, r->num, i, &r->power[i]);
    tidy(b, r);
    return true;
}

bool poly_ratio_mul(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x, const struct poly_ratio *y)
{
    assert(poly_ratio_sane(b, x) && poly_ratio_sane(b, y));
    if (fmpz_mpoly_is_zero(x->num, b->ctx) || fmpz_mpoly_is_zero(y->num, b->ctx)) {
        fmpz_mpoly_zero(r->num, b->ctx);
        tidy(b, r);
        return true;
    }
    struct poly_ratio u, v;
    poly_ratio_init(b, &u);
    poly_ratio_init(b, &v);
    poly_ratio_set(b, &u, x);
    poly_ratio_set(b, &v, y);
    for (int i = 0; i < b->bases; i++) {
        if (v.power[i])
            cancel(b, u.num, i, &v.power[i]);
        if (u.power[i])
            cancel(b, v.num, i, &u.power[i]);
        r->power[i] = u.power[i] + v.power[i];
    }
    bool ok = (long)(fmpz_bits(x->scale) + fmpz_bits(y->scale)) <= b->limits.max_bits;
    if (ok)
        fmpz_mul(r->scale, x->scale, y->scale);
    ok = ok && poly_mul(b, r->num, u.num, v.num);
    poly_ratio_clear(b, &u);
    poly_ratio_clear(b, &v);
    tidy(b, r);
    return ok && poly_reduce_ratio(b, r);
}

/* The index of f in the list of denominator factors, or -1 if the list is full. */
static int base_add(struct poly_bridge *b, const fmpz_mpoly_t f, bool prime)
{
    if (b->bases == POLY_MAX_BASE)
        return -1;
    struct poly_base *n = b->base + b->bases;
    fmpz_mpoly_init(n->f, b->ctx);
    fmpz_mpoly_set(n->f, f, b->ctx);
    n->prime = prime;
    return b->bases++;
}

static int base_of_generator(struct poly_bridge *b, int g)
{
    if (b->gen[g].in_base < 0) {
        SGA_ARENA(mem);
        fmpz_mpoly_struct *x = mpoly_take(&mem, b->ctx);
        fmpz_mpoly_gen(x, g, b->ctx);
        b->gen[g].in_base = base_add(b, x, true);
    }
    return b->gen[g].in_base;
}

/* f = content * product of base^power; f is used up. New factors join the list. */
static bool decompose(struct poly_bridge *b, fmpz_mpoly_t f, fmpz_t content, int *power)
{
    poly_content(content, f);
    if (fmpz_sgn(f->coeffs) < 0)
        fmpz_neg(content, content);
    fmpz_mpoly_scalar_divexact_fmpz(f, f, content, b->ctx);
    for (int g = 0; g < b->gens; g++) {
        ulong least = UWORD_MAX;
        for (slong i = 0; i < f->length && least > 0; i++) {
            ulong e = fmpz_mpoly_get_term_var_exp_ui(f, i, g, b->ctx);
            least = e < least ? e : least;
        }
        if (least == 0)
            continue;
        int i = base_of_generator(b, g);
        if (i < 0 || least > (ulong)b->limits.max_degree)
            return false;
        power[i] += (int)least;
        SGA_ARENA(mem);
        fmpz_mpoly_struct *m = mpoly_take(&mem, b->ctx);
        fmpz_mpoly_pow_ui(m, b->base[i].f, least, b->ctx);
        fmpz_mpoly_divides(f, f, m, b->ctx);
    }
    for (int i = 0; i < b->bases && !fmpz_mpoly_is_one(f, b->ctx); i++)
        while (b->base[i].f->length > 1 && poly_divides(b, f, f, b->base[i].f))
            power[i]++;
    if (fmpz_mpoly_is_one(f, b->ctx))
        return true;
    int i = base_add(b, f, poly_surely_prime(b, f));
    if (i >= 0)
        power[i]++;
    return i >= 0;
}

/* r = 1 / x for x reduced by all relations (so that it is zero only if it looks so). */
static bool inverse(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x)
{
    SGA_ENDS(fmpz_end) fmpz_t content = { 0 };
    SGA_ARENA(mem);
    int below[POLY_MAX_BASE] = { 0 };
    fmpz_mpoly_struct *f = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_set(f, x->num, b->ctx);
    bool ok = decompose(b, f, content, below);
    if (ok) {
        fmpz_mpoly_set_fmpz(r->num, x->scale, b->ctx);
        if (fmpz_sgn(content) < 0)
            fmpz_mpoly_neg(r->num, r->num, b->ctx);
        fmpz_abs(r->scale, content);
        for (int i = 0; ok && i < b->bases; i++) {
            int up = x->power[i] - below[i];
            r->power[i] = up < 0 ? -up : 0;
            ok = up <= 0 || multiply_by_base(b, r->num, i, up);
        }
        tidy(b, r);
    }
    return ok;
}

bool poly_ratio_inv(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x)
{
    struct poly_ratio u;
    poly_ratio_init(b, &u);
    poly_ratio_set(b, &u, x);
    bool ok = poly_reduce_ratio(b, &u) && !fmpz_mpoly_is_zero(u.num, b->ctx) && inverse(b, r, &u);
    poly_ratio_clear(b, &u);
    assert(!ok || poly_ratio_sane(b, r));
    return ok;
}

bool poly_ratio_pow(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x, long n)
{
    assert(poly_ratio_sane(b, x));
    if (n < 0) {
        struct poly_ratio u;
        poly_ratio_init(b, &u);
        bool ok = poly_ratio_inv(b, &u, x) && poly_ratio_pow(b, r, &u, -n);
        poly_ratio_clear(b, &u);
        return ok;
    }
    if ((double)fmpz_bits(x->scale) * (double)n > (double)b->limits.max_bits && !fmpz_is_one(x->scale))
        return false;
    for (int i = 0; i < b->bases; i++) {
        if ((double)x->power[i] * (double)n > (double)b->limits.max_degree)
            return false;
        r->power[i] = x->power[i] * (int)n;
    }
    if (!poly_pow(b, r->num, x->num, n))
        return false;
    fmpz_pow_ui(r->scale, x->scale, (ulong)n);
    return poly_reduce_ratio(b, r);
}
