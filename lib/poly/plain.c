/* Values and zeros on a set, as short as is cheap.
 *
 * Where g vanishes, a term m t of f may be replaced by what g = 0 makes of m: for each term c m of
 * each g, all multiples of m in f are taken out at once (f becomes c f - q g, and that over c), and the
 * step that shortens f most is taken until none does. This is no normal form, and needs no Groebner
 * basis: a step is an identity on the set, whatever its order, and lengths fall, so it ends. Lengths
 * count every name as two signs, so nothing depends on how names are spelt. */
#include "bridge.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "error.h"
#include "facts.h"
#include "flint_ends.h"
#include "mem.h"
#include "mpoly_take.h"
#include "print.h"

/* Of what is tried: f, and each g. */
enum { F_TERMS = 120, G_TERMS = 30, MOST_SET = 40, STEPS = 24 };
/* What is longer than so many times what is known already is not looked at: factors, and steps, shorten by less as a rule. */
enum { FACTORED = 2, REDUCED = 3 };

/* Names and pi count two signs, functions so many. */
enum { NAME = 2, FUNCTION = 8 };

/* About how many signs f takes as a sum. */
static long length_of(const struct poly_bridge *b, const fmpz_mpoly_t f, ulong *exp)
{
    long n = 0;
    for (slong i = 0; i < f->length; i++) {
        bool one = fmpz_is_pm1(f->coeffs + i), any = false;
        poly_exponents(b, f, i, exp);
        n += one ? 1 : 1 + (long)fmpz_sizeinbase(f->coeffs + i, 10);
        for (int g = 0; g < b->gens; g++)
            if (exp[g]) {
                n += (b->gen[g].op == EXPR_SYM ? NAME : FUNCTION) + (any || !one) + (exp[g] > 1 ? 2 : 0);
                any = true;
            }
        n += one && !any;
    }
    return n;
}

/* f without its content, which multiplies `scale`. */
static void strip(struct poly_bridge *b, fmpz_mpoly_t f, fmpq_t scale)
{
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    if (f->length) {
        poly_content(c, f);
        fmpz_mpoly_scalar_divexact_fmpz(f, f, c, b->ctx);
        fmpq_mul_fmpz(scale, scale, c);
    }
}

/* q: the multiples of the term m = coeff * x^exp that f has, over x^exp. False: none. */
static bool quotient(struct poly_bridge *b, fmpz_mpoly_t q, const fmpz_mpoly_t f, const ulong *m, ulong *exp)
{
    fmpz_mpoly_zero(q, b->ctx);
    for (slong i = 0; i < f->length; i++) {
        bool divisible = true;
        poly_exponents(b, f, i, exp);
        for (int g = 0; g < b->gens && divisible; g++)
            divisible = exp[g] >= m[g];
        if (!divisible)
            continue;
        for (int g = 0; g < b->gens; g++)
            exp[g] -= m[g];
        fmpz_mpoly_push_term_fmpz_ui(q, f->coeffs + i, exp, b->ctx);
    }
    fmpz_mpoly_sort_terms(q, b->ctx);
    return q->length > 0;
}

/* Whether the monomial has a generator that is no parameter: those stay what they are. */
static bool moves(const struct poly_bridge *b, const ulong *m)
{
    for (int g = 0; g < b->gens; g++)
        if (m[g] && b->gen[g].depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME))
            return true;
    return false;
}

/* The best step of f by one of the set's functions: f = scale f' on the set. False: none shortens it. */
static bool step(struct poly_bridge *b, fmpz_mpoly_t f, fmpq_t scale, fmpz_mpoly_struct *set, int count)
{
    SGA_FREED ulong *m = sga_malloc(2 * (size_t)b->max_gens * sizeof *m);
    ulong *exp = m + b->max_gens;
    SGA_ARENA(mem);
    SGA_ENDS(fmpq_end) fmpq_t by = { { 0, 1 } }, best_by = { { 0, 1 } };
    long least = length_of(b, f, exp);
    bool found = false;
    fmpz_mpoly_struct *q = mpoly_take(&mem, b->ctx), *p = mpoly_take(&mem, b->ctx), *best = mpoly_take(&mem, b->ctx);
    for (int k = 0; k < count; k++)
        for (slong i = 0; i < set[k].length; i++) {
            poly_exponents(b, set + k, i, m);
            if (!moves(b, m) || !quotient(b, q, f, m, exp) || !poly_mul(b, p, q, set + k))
                continue;
            fmpz_mpoly_scalar_mul_fmpz(q, f, set[k].coeffs + i, b->ctx);
            fmpz_mpoly_sub(p, q, p, b->ctx);
            fmpq_one(by);
            fmpq_div_fmpz(by, by, set[k].coeffs + i);
            strip(b, p, by);
            long length = length_of(b, p, exp);
            if (length >= least || !poly_fits(b, p))
                continue;
            least = length;
            fmpz_mpoly_swap(best, p, b->ctx);
            fmpq_swap(best_by, by);
            found = true;
        }
    if (found) {
        fmpz_mpoly_swap(f, best, b->ctx);
        fmpq_mul(scale, scale, best_by);
    }
    assert(!found || (best_by->num != 0 && length_of(b, f, exp) == least));
    return found;
}

/* f = scale f' on the set; true: some step was taken. */
static bool reduce(struct poly_bridge *b, fmpz_mpoly_t f, fmpq_t scale, fmpz_mpoly_struct *set, int count)
{
    bool any = false;
    for (int k = 0; k < STEPS && f->length && f->length <= F_TERMS && step(b, f, scale, set, count); k++)
        any = true;
    return any;
}

/* The numerators of the functions that vanish on the set; the caller clears them. */
static int set_of(struct poly_bridge *b, const expr_id *by, int count, fmpz_mpoly_struct *set)
{
    int n = 0;
    for (int i = 0; i < count && n < MOST_SET; i++) {
        const struct poly_ratio *r = poly_value(b, by[i]);
        struct poly_fraction f;
        if (!r || !poly_fraction_of(b, r, &f))
            continue;
        SGA_ENDS(fmpq_end) fmpq_t ignored = { { 0, 1 } };
        if (f.num->length && f.num->length <= G_TERMS) {
            fmpz_mpoly_init(set + n, b->ctx);
            fmpz_mpoly_set(set + n, f.num, b->ctx);
            strip(b, set + n, ignored);
            n++;
        }
        poly_fraction_clear(b, &f);
    }
    return n;
}

static void set_clear(struct poly_bridge *b, fmpz_mpoly_struct *set, int count)
{
    for (int i = 0; i < count; i++)
        fmpz_mpoly_clear(set + i, b->ctx);
}

/* The fraction's denominators as one polynomial; false: too large. */
static bool below(struct poly_bridge *b, const struct poly_fraction *f, fmpz_mpoly_t den)
{
    SGA_ARENA(mem);
    bool ok = true;
    fmpz_mpoly_one(den, b->ctx);
    fmpz_mpoly_struct *p = mpoly_take(&mem, b->ctx);
    for (int i = 0; i < f->dens && ok; i++)
        ok = poly_pow(b, p, f->den[i].f, f->den[i].n) && poly_mul(b, den, den, p);
    return ok;
}

/* scale * num / den as an expression in lowest terms. */
static bool show_fraction(struct poly_bridge *b, fmpz_mpoly_t num, fmpz_mpoly_t den, fmpq_t scale, expr_id *out)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *g = mpoly_take(&mem, b->ctx);
    bool ok = !fmpz_mpoly_is_zero(den, b->ctx);
    if (ok && num->length && !fmpz_mpoly_is_fmpz(den, b->ctx) && poly_gcd(b, g, num, den) && !fmpz_mpoly_is_fmpz(g, b->ctx))
        ok = fmpz_mpoly_divides(num, num, g, b->ctx) && fmpz_mpoly_divides(den, den, g, b->ctx);
    if (!ok)
        return false;
    SGA_ENDS(fmpq_end) fmpq_t below_by = { { 0, 1 } };
    fmpq_one(below_by);
    strip(b, num, scale);
    strip(b, den, below_by);
    if (fmpz_sgn(den->coeffs) < 0) {
        fmpz_mpoly_neg(den, den, b->ctx);
        fmpq_neg(below_by, below_by);
    }
    fmpq_div(scale, scale, below_by);
    struct poly_power power = { .n = 1 };
    struct poly_fraction f = { .den = &power, .dens = !fmpz_mpoly_is_one(den, b->ctx) };
    fmpz_mpoly_init(f.num, b->ctx);
    fmpz_init(f.scale);
    fmpz_mpoly_init(power.f, b->ctx);
    fmpz_mpoly_set(power.f, den, b->ctx);
    fmpz_mpoly_scalar_mul_fmpz(f.num, num, fmpq_numref(scale), b->ctx);
    fmpz_set(f.scale, fmpq_denref(scale));
    ok = poly_show(b, &f, out);
    fmpz_mpoly_clear(power.f, b->ctx);
    fmpz_mpoly_clear(f.num, b->ctx);
    fmpz_clear(f.scale);
    return ok;
}

/* The same of a fraction, each factor of the denominator as a sum. */
static long fraction_length(const struct poly_bridge *b, const struct poly_fraction *f)
{
    SGA_FREED ulong *exp = sga_malloc((size_t)b->max_gens * sizeof *exp);
    long n = length_of(b, f->num, exp);
    for (int i = 0; i < f->dens; i++)
        n += length_of(b, f->den[i].f, exp);
    return n;
}

bool poly_bridge_normal_within(struct poly_bridge *b, expr_id e, long most, expr_id *out)
{
    const struct poly_ratio *r = poly_value(b, e);
    struct poly_fraction f;
    if (!r || !poly_fraction_of(b, r, &f))
        return false;
    bool ok = fraction_length(b, &f) <= FACTORED * most && poly_show(b, &f, out);
    poly_fraction_clear(b, &f);
    return ok;
}

bool poly_bridge_on_set(struct poly_bridge *b, expr_id e, const expr_id *by, int count, long most, expr_id *out)
{
    const struct poly_ratio *r = poly_value(b, e);
    struct poly_fraction f;
    if (!count || !r || !poly_fraction_of(b, r, &f))
        return false;
    SGA_FREED fmpz_mpoly_struct *set = sga_malloc(MOST_SET * sizeof *set);
    int n = set_of(b, by, count, set);
    SGA_ARENA(mem);
    SGA_ENDS(fmpq_end) fmpq_t scale = { { 0, 1 } }, down = { { 0, 1 } };
    fmpz_mpoly_struct *den = mpoly_take(&mem, b->ctx);
    fmpq_set_si(scale, 1, 1);
    fmpq_one(down);
    fmpq_div_fmpz(scale, scale, f.scale);
    bool ok = n && fraction_length(b, &f) <= REDUCED * most && below(b, &f, den) && f.num->length <= F_TERMS && den->length <= F_TERMS;
    if (ok) {
        strip(b, f.num, scale);
        bool above = reduce(b, f.num, scale, set, n), under = reduce(b, den, down, set, n);
        fmpq_div(scale, scale, down);
        ok = (above || under) && show_fraction(b, f.num, den, scale, out);
    }
    set_clear(b, set, n);
    poly_fraction_clear(b, &f);
    return ok;
}

/* The generators of a term by name, in alphabetical order: an order that does not depend on theirs. */
static int by_text(const void *x, const void *y)
{
    return strcmp(*(char *const *)x, *(char *const *)y);
}

static char *monomial_text(const struct poly_bridge *b, const fmpz_mpoly_t f, slong i, ulong *exp)
{
    SGA_FREED char **part = sga_calloc((size_t)b->max_gens, sizeof *part);
    struct sga_buf all = { 0 };
    int n = 0;
    poly_exponents(b, f, i, exp);
    for (int g = 0; g < b->gens; g++)
        if (exp[g]) {
            struct sga_buf t = { 0 };
            if (!expr_print(b->st, b->gen[g].node, 400, &t))
                sga_buf_puts(&t, "~");
            sga_buf_printf(&t, "^%lu", exp[g]);
            part[n++] = sga_buf_take(&t);
        }
    qsort(part, (size_t)n, sizeof *part, by_text);
    for (int k = 0; k < n; k++) {
        sga_buf_puts(&all, part[k]);
        free(part[k]);
    }
    return sga_buf_take(&all);
}

/* The sign of f: that of most of its terms, else of those of highest degree, else of the first by name. */
static int sign_of(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    SGA_FREED ulong *exp = sga_malloc((size_t)b->max_gens * sizeof *exp);
    ulong highest = 0;
    long most = 0, top = 0;
    char *first = NULL;
    int sign = 0;
    for (slong i = 0; i < f->length; i++) {
        int s = fmpz_sgn(f->coeffs + i);
        ulong degree = 0;
        poly_exponents(b, f, i, exp);
        for (int g = 0; g < b->gens; g++)
            degree += exp[g];
        if (degree > highest) {
            highest = degree;
            top = 0;
        }
        top += degree == highest ? s : 0;
        most += s;
    }
    sign = most ? (most > 0) - (most < 0) : (top > 0) - (top < 0);
    for (slong i = 0; i < f->length && !most && !top; i++) {
        char *text = monomial_text(b, f, i, exp);
        if (!first || strcmp(text, first) < 0) {
            free(first);
            first = text;
            sign = fmpz_sgn(f->coeffs + i);
        } else {
            free(text);
        }
    }
    free(first);
    return sign < 0 ? -1 : 1;
}

/* s over the fraction's denominators. */
static expr_id scale_of(struct poly_bridge *b, const struct poly_fraction *f, const fmpq_t s)
{
    expr_id e = expr_fmpq(b->st, s);
    for (int i = 0; i < f->dens; i++)
        e = expr_div(b->st, e, expr_powi(b->st, poly_show_poly(b, f->den[i].f), f->den[i].n));
    return e;
}

bool poly_bridge_zeros(struct poly_bridge *b, expr_id e, const expr_id *by, int count, long most, expr_id *out, expr_id *scale, bool *reduced)
{
    const struct poly_ratio *r = poly_value(b, e);
    struct poly_fraction f;
    if (!r || !poly_fraction_of(b, r, &f))
        return false;
    SGA_FREED fmpz_mpoly_struct *set = sga_malloc(MOST_SET * sizeof *set);
    int n = set_of(b, by, count, set);
    SGA_ENDS(fmpq_end) fmpq_t s = { { 0, 1 } };
    fmpq_one(s);
    fmpq_div_fmpz(s, s, f.scale);
    bool ok = f.num->length && fraction_length(b, &f) <= REDUCED * most;
    *reduced = false;
    if (ok) {
        strip(b, f.num, s);
        *reduced = n && reduce(b, f.num, s, set, n);
        ok = f.num->length > 0;
    }
    if (ok && sign_of(b, f.num) < 0) {
        fmpz_mpoly_neg(f.num, f.num, b->ctx);
        fmpq_neg(s, s);
    }
    if (ok) {
        struct sga_error before = *b->st->error;
        *out = poly_show_poly(b, f.num);
        *scale = scale_of(b, &f, s);
        ok = *out && *scale && expr_store_ok(b->st);
        *b->st->error = before;
    }
    set_clear(b, set, n);
    poly_fraction_clear(b, &f);
    return ok;
}
