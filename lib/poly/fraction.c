/* A value in lowest terms, the denominator kept in factors.
 *
 * Factors that are known to be irreducible need trial division only; the others cost one
 * gcd each. Squares of sines and cosines are turned into each other where that makes a
 * polynomial shorter: 1 - cos(x)^2 is shown, and cancelled, as sin(x)^2. */
#include "bridge.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"
#include "mpoly_take.h"

static void den_push(const struct poly_bridge *b, struct poly_fraction *f, const fmpz_mpoly_t p, long n)
{
    SGA_RESERVE(f->den, f->den_cap, f->dens + 1);
    struct poly_power *d = f->den + f->dens++;
    fmpz_mpoly_init(d->f, b->ctx);
    fmpz_mpoly_set(d->f, p, b->ctx);
    d->n = n;
}

static void den_drop(const struct poly_bridge *b, struct poly_fraction *f, int i)
{
    fmpz_mpoly_clear(f->den[i].f, b->ctx);
    f->den[i] = f->den[--f->dens];
}

void poly_fraction_clear(const struct poly_bridge *b, struct poly_fraction *f)
{
    while (f->dens > 0)
        den_drop(b, f, f->dens - 1);
    free(f->den);
    fmpz_mpoly_clear(f->num, b->ctx);
    fmpz_clear(f->scale);
}

/* Factors whose power has gone, or that became constants, leave; signs and integer
 * contents move to the numerator and the scale. */
static bool settle(struct poly_bridge *b, struct poly_fraction *f)
{
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    bool ok = true;
    for (int i = f->dens - 1; ok && i >= 0; i--) {
        struct poly_power *d = f->den + i;
        poly_content(c, d->f);
        if (d->n > 0 && !fmpz_is_one(c)) {
            ok = (double)fmpz_bits(c) * (double)d->n <= (double)b->limits.max_bits;
            if (!ok)
                break;
            fmpz_mpoly_scalar_divexact_fmpz(d->f, d->f, c, b->ctx);
            fmpz_pow_ui(c, c, (ulong)d->n);
            fmpz_mul(f->scale, f->scale, c);
        }
        if (d->n > 0 && fmpz_sgn(d->f->coeffs) < 0) {
            fmpz_mpoly_neg(d->f, d->f, b->ctx);
            if (d->n % 2)
                fmpz_mpoly_neg(f->num, f->num, b->ctx);
        }
        if (d->n == 0 || fmpz_mpoly_is_one(d->f, b->ctx))
            den_drop(b, f, i);
    }
    poly_content(c, f->num);
    fmpz_gcd(c, c, f->scale);
    if (!fmpz_is_one(c)) {
        fmpz_mpoly_scalar_divexact_fmpz(f->num, f->num, c, b->ctx);
        fmpz_divexact(f->scale, f->scale, c);
    }
    return ok && (long)fmpz_bits(f->scale) <= b->limits.max_bits;
}

static void cancel_exact(struct poly_bridge *b, struct poly_fraction *f)
{
    for (int i = 0; i < f->dens; i++)
        while (f->den[i].n > 0 && poly_divides(b, f->num, f->num, f->den[i].f))
            f->den[i].n--;
}

static bool known_prime(const struct poly_bridge *b, const fmpz_mpoly_t d)
{
    if (d->length == 1)
        return true;
    for (int i = 0; i < b->bases; i++)
        if (b->base[i].prime && fmpz_mpoly_equal(b->base[i].f, d, b->ctx))
            return true;
    return false;
}

/* Common factors that are proper factors of a denominator factor: it is split. */
static bool cancel_common(struct poly_bridge *b, struct poly_fraction *f)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *g = mpoly_take(&mem, b->ctx);
    bool ok = true;
    for (int i = 0; ok && i < f->dens; i++) {
        if (f->den[i].n == 0 || known_prime(b, f->den[i].f))
            continue;
        ok = poly_gcd(b, g, f->num, f->den[i].f);
        if (!ok || fmpz_mpoly_is_fmpz(g, b->ctx))
            continue;
        ok = fmpz_mpoly_divides(f->num, f->num, g, b->ctx)
            && fmpz_mpoly_divides(f->den[i].f, f->den[i].f, g, b->ctx);
        if (f->den[i].n > 1)
            den_push(b, f, g, f->den[i].n - 1);
        i--;        /* what is left of this factor may have more in common */
    }
    return ok;
}

/* Replaces f by the shorter of f and f with cos^2 -> 1 - sin^2. */
static void shorten(struct poly_bridge *b, fmpz_mpoly_t f, int c, const fmpz_mpoly_t p, const fmpz_mpoly_t one)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *g = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_set(g, f, b->ctx);
    if (poly_reduce_by(b, g, c, 2, p, one) > 0 && g->length < f->length)
        fmpz_mpoly_swap(f, g, b->ctx);
}

static bool shorten_pairs(struct poly_bridge *b, struct poly_fraction *f)
{
    bool any = false;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *p = mpoly_take(&mem, b->ctx), *one = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_one(one, b->ctx);
    for (int s = 0; s < b->gens; s++) {
        int c = b->gen[s].partner;
        if (c < 0)
            continue;
        any = true;
        fmpz_mpoly_gen(p, s, b->ctx);
        fmpz_mpoly_mul(p, p, p, b->ctx);
        if (b->gen[s].op == EXPR_SIN)
            fmpz_mpoly_sub(p, one, p, b->ctx);
        else
            fmpz_mpoly_add(p, one, p, b->ctx);      /* cosh^2 = 1 + sinh^2 */
        shorten(b, f->num, c, p, one);
        for (int i = 0; i < f->dens; i++)
            shorten(b, f->den[i].f, c, p, one);
    }
    return any;
}

/* x/sqrt(x) is sqrt(x): a root below the line moves up where the numerator then cancels
 * against what is under it. */
static bool raise_roots(struct poly_bridge *b, struct poly_fraction *f)
{
    bool changed = false;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *n = mpoly_take(&mem, b->ctx), *q = mpoly_take(&mem, b->ctx);
    for (int i = 0; i < f->dens; i++) {
        for (int g = 0; g < b->gens; g++) {
            const struct poly_generator *x = b->gen + g;
            if (!x->degree || x->partner >= 0 || x->in_base < 0 || f->den[i].n != 1
                || !fmpz_mpoly_equal(f->den[i].f, b->base[x->in_base].f, b->ctx)
                || !poly_divides(b, q, f->num, x->p))
                continue;
            fmpz_mpoly_pow_ui(n, f->den[i].f, (ulong)x->degree - 1, b->ctx);
            if (poly_mul(b, q, q, n) && poly_mul(b, f->num, q, x->q)) {
                f->den[i].n = 0;
                changed = true;
                break;
            }
        }
    }
    return changed;
}

static bool lowest_terms(struct poly_bridge *b, struct poly_fraction *f)
{
    cancel_exact(b, f);
    if (!cancel_common(b, f))
        return false;
    if (shorten_pairs(b, f)) {
        cancel_exact(b, f);
        if (!cancel_common(b, f))
            return false;
    }
    if (b->relations > 0 && f->dens > 0 && raise_roots(b, f))
        cancel_exact(b, f);
    return settle(b, f);
}

bool poly_fraction_sane(const struct poly_fraction *f)
{
    bool sane = fmpz_sgn(f->scale) > 0;
    for (int i = 0; i < f->dens && sane; i++)
        sane = f->den[i].n > 0 && f->den[i].f->length > 0 && fmpz_sgn(f->den[i].f->coeffs) > 0;
    return sane;
}

bool poly_fraction_of(struct poly_bridge *b, const struct poly_ratio *r, struct poly_fraction *f)
{
    *f = (struct poly_fraction){ 0 };
    fmpz_mpoly_init(f->num, b->ctx);
    fmpz_init_set_ui(f->scale, 1);
    struct poly_ratio u;
    poly_ratio_init(b, &u);
    poly_ratio_set(b, &u, r);
    bool ok = poly_reduce_ratio(b, &u);
    if (ok && !fmpz_mpoly_is_zero(u.num, b->ctx)) {
        fmpz_mpoly_swap(f->num, u.num, b->ctx);
        fmpz_swap(f->scale, u.scale);
        for (int i = 0; i < b->bases; i++)
            if (u.power[i] > 0)
                den_push(b, f, b->base[i].f, u.power[i]);
        ok = lowest_terms(b, f) && f->num->length <= b->limits.max_terms;
    }
    poly_ratio_clear(b, &u);
    if (!ok)
        poly_fraction_clear(b, f);
    assert(!ok || poly_fraction_sane(f));
    return ok;
}
