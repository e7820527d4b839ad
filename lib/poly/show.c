/* Fractions as expressions that are pleasant to read: common factors in front, rational
 * coefficients where they are shorter than a common denominator, the denominator in the
 * factors it came in, exponentials above the line. The result is always equal to the
 * fraction, never a multiple of it. */
#include "bridge.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <flint/fmpz_mpoly_factor.h>

#include "arena.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "mpoly_take.h"

/* Factoring for display is tried within these only: it must stay cheap. */
enum { FACTOR_TERMS = 24, FACTOR_DEGREE = 8 };

expr_id poly_show_power(struct poly_bridge *b, int gen, long n)
{
    assert(gen >= 0 && gen < b->gens);
    const struct poly_generator *g = b->gen + gen;
    expr_id e = EXPR_UNDEF;
    if (n == 1 || (g->root == 0 && fmpq_is_zero(g->content)))
        return expr_powi(b->st, g->node, n);
    SGA_ENDS(fmpq_end) fmpq_t q = { { 0, 1 } };
    if (g->root) {
        fmpq_set_si(q, n, (ulong)g->root);
        e = expr_pow(b->st, g->base, expr_fmpq(b->st, q));
    } else {
        fmpq_mul_si(q, g->content, n);
        e = expr_fun(b->st, EXPR_EXP, expr_mul(b->st, expr_fmpq(b->st, q), g->key));
    }
    return e;
}

static expr_id monomial(struct poly_bridge *b, const ulong *exp)
{
    expr_id e = expr_int(b->st, 1);
    for (int g = 0; g < b->gens; g++)
        if (exp[g])
            e = expr_mul(b->st, e, poly_show_power(b, g, (long)exp[g]));
    return e;
}

/* scale * f as a sum, its first terms first. */
static expr_id sum_of(struct poly_bridge *b, const fmpz_mpoly_t f, const fmpq_t scale)
{
    SGA_ARENA(mem);
    expr_id *term = sga_take(&mem, ((size_t)f->length + 1) * sizeof *term);
    ulong *exp = sga_take(&mem, (size_t)b->max_gens * sizeof *exp);
    SGA_ENDS(fmpq_end) fmpq_t c = { { 0, 1 } };
    for (slong i = 0; i < f->length; i++) {
        poly_exponents(b, f, i, exp);
        fmpq_mul_fmpz(c, scale, f->coeffs + i);
        expr_id m = monomial(b, exp);
        if (fmpq_sgn(c) < 0) {
            fmpq_neg(c, c);
            term[i] = expr_neg(b->st, expr_mul(b->st, expr_fmpq(b->st, c), m));
        } else {
            term[i] = expr_mul(b->st, expr_fmpq(b->st, c), m);
        }
    }
    expr_id e = f->length ? term[f->length - 1] : expr_int(b->st, 0);
    for (slong i = f->length - 1; i-- > 0;)
        e = expr_add(b->st, term[i], e);
    return e;
}

expr_id poly_show_poly(struct poly_bridge *b, const fmpz_mpoly_t f)
{
    SGA_ENDS(fmpq_end) fmpq_t one = { { 0, 1 } };
    fmpq_set_si(one, 1, 1);
    return sum_of(b, f, one);
}

static long digits(const fmpz_t c)
{
    return fmpz_is_pm1(c) ? 0 : (long)fmpz_sizeinbase(c, 10);
}

/* About how many characters f takes as a sum. */
static long length_of(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    SGA_FREED ulong *exp = sga_malloc((size_t)b->max_gens * sizeof *exp);
    long n = 0;
    for (slong i = 0; i < f->length; i++) {
        poly_exponents(b, f, i, exp);
        n += 3 + digits(f->coeffs + i);
        for (int g = 0; g < b->gens; g++)
            if (exp[g])
                n += (b->gen[g].op == EXPR_SYM ? (long)strlen(b->st->symbol[b->st->node[b->gen[g].node].a].name) : 6)
                    + (exp[g] > 1 ? 3 : 1);
    }
    return n;
}

/* The monomial that all terms share, into exp; f is divided by it. True if there is one. */
static bool take_monomial(struct poly_bridge *b, fmpz_mpoly_t f, ulong *exp)
{
    SGA_FREED ulong *e = sga_malloc((size_t)b->max_gens * sizeof *e);
    bool any = false;
    poly_exponents(b, f, 0, exp);
    for (slong i = 1; i < f->length; i++) {
        poly_exponents(b, f, i, e);
        for (int g = 0; g < b->gens; g++)
            exp[g] = e[g] < exp[g] ? e[g] : exp[g];
    }
    for (int g = 0; g < b->max_gens; g++)
        any = any || exp[g];
    if (any) {
        SGA_ARENA(mem);
        fmpz_mpoly_struct *m = mpoly_take(&mem, b->ctx);
        fmpz_mpoly_set_coeff_si_ui(m, 1, exp, b->ctx);
        fmpz_mpoly_divides(f, f, m, b->ctx);
    }
    return any;
}

/* f (primitive, no monomial content, positive leading coefficient) in factors, where
 * that is cheap and shorter; otherwise EXPR_UNDEF. */
static expr_id in_factors(struct poly_bridge *b, const fmpz_mpoly_t f)
{
    if (f->length < 3 || f->length > FACTOR_TERMS || poly_degree(b, f) > FACTOR_DEGREE || poly_surely_prime(b, f))
        return EXPR_UNDEF;
    fmpz_mpoly_factor_t fac;
    fmpz_mpoly_factor_init(fac, b->ctx);
    expr_id e = EXPR_UNDEF;
    if (fmpz_mpoly_factor(fac, f, b->ctx) && (fac->num > 1 || !fmpz_is_one(fac->exp)) && fmpz_is_pm1(fac->constant)) {
        long factored = 0;
        for (slong i = 0; i < fac->num; i++)
            factored += length_of(b, fac->poly + i) + 2;
        if (factored < length_of(b, f)) {
            e = expr_int(b->st, fmpz_get_si(fac->constant));
            for (slong i = 0; i < fac->num; i++)
                e = expr_mul(b->st, e, expr_powi(b->st, poly_show_poly(b, fac->poly + i), fmpz_get_si(fac->exp + i)));
        }
    }
    fmpz_mpoly_factor_clear(fac, b->ctx);
    return e;
}

/* A primitive polynomial as a product of a monomial and a sum, or of factors. */
static expr_id product_of(struct poly_bridge *b, const fmpz_mpoly_t f)
{
    SGA_ARENA(mem);
    SGA_FREED ulong *exp = sga_calloc((size_t)b->max_gens, sizeof *exp);
    fmpz_mpoly_struct *rest = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_set(rest, f, b->ctx);
    take_monomial(b, rest, exp);
    expr_id sum = in_factors(b, rest);
    if (!sum)
        sum = poly_show_poly(b, rest);
    return expr_mul(b->st, monomial(b, exp), sum);
}

/* The rational content in front, or spread over the terms: what is shorter. */
static expr_id polynomial(struct poly_bridge *b, const fmpz_mpoly_t f, const fmpq_t content)
{
    long front = digits(fmpq_numref(content)) + digits(fmpq_denref(content)) + 3, spread = 0;
    SGA_ENDS(fmpq_end) fmpq_t c = { { 0, 1 } };
    for (slong i = 0; i < f->length; i++) {
        fmpq_mul_fmpz(c, content, f->coeffs + i);
        spread += digits(fmpq_numref(c)) + (fmpz_is_one(fmpq_denref(c)) ? 0 : 1 + digits(fmpq_denref(c)));
        front += digits(f->coeffs + i);
    }
    expr_id product = product_of(b, f);
    enum expr_op op = expr_op_of(b->st, product);
    bool is_sum = op == EXPR_ADD || op == EXPR_SUB || op == EXPR_NEG;
    if (is_sum && spread <= front)
        return sum_of(b, f, content);
    return expr_mul(b->st, expr_fmpq(b->st, content), product);
}

/* Exponentials below the line are written above it, with the opposite sign. Returns the
 * factor's generator, or -1. */
static int exponential_factor(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    for (int g = 0; g < b->gens; g++)
        if (b->gen[g].op == EXPR_EXP && !fmpq_is_zero(b->gen[g].content) && b->gen[g].in_base >= 0
            && fmpz_mpoly_equal(f, b->base[b->gen[g].in_base].f, b->ctx))
            return g;
    return -1;
}

static expr_id denominator(struct poly_bridge *b, const struct poly_fraction *f, expr_id *above)
{
    expr_id e = expr_int(b->st, 1);
    *above = expr_int(b->st, 1);
    for (int i = 0; i < f->dens; i++) {
        const struct poly_power *d = f->den + i;
        int g = exponential_factor(b, d->f);
        if (g >= 0)
            *above = expr_mul(b->st, *above, poly_show_power(b, g, -d->n));
        else
            e = expr_mul(b->st, e, expr_powi(b->st, product_of(b, d->f), d->n));
    }
    return e;
}

bool poly_show(struct poly_bridge *b, const struct poly_fraction *f, expr_id *out)
{
    assert(poly_fraction_sane(f));
    struct sga_error before = *b->st->error;
    SGA_ARENA(mem);
    SGA_ENDS(fmpq_end) fmpq_t content = { { 0, 1 } };
    fmpz_mpoly_struct *primitive = mpoly_take(&mem, b->ctx);
    expr_id e = expr_int(b->st, 0), above;
    if (f->num->length > 0) {
        poly_content(fmpq_numref(content), f->num);
        fmpz_set(fmpq_denref(content), f->scale);
        fmpz_mpoly_scalar_divexact_fmpz(primitive, f->num, fmpq_numref(content), b->ctx);
        fmpq_canonicalise(content);
        expr_id below = denominator(b, f, &above);
        if (expr_is_one(b->st, below)) {
            e = expr_mul(b->st, polynomial(b, primitive, content), above);
        } else {
            expr_id top = expr_mul(b->st, product_of(b, primitive), above);
            e = expr_mul(b->st, expr_fmpq(b->st, content), expr_div(b->st, top, below));
        }
    }
    bool ok = expr_store_ok(b->st) && e != EXPR_UNDEF;
    *b->st->error = before;
    if (ok)
        *out = e;
    return ok;
}

bool poly_bridge_normal(struct poly_bridge *b, expr_id e, expr_id *out)
{
    const struct poly_ratio *r = poly_value(b, e);
    struct poly_fraction f;
    if (!r || !poly_fraction_of(b, r, &f))
        return false;
    bool ok = poly_show(b, &f, out);
    poly_fraction_clear(b, &f);
    return ok;
}
