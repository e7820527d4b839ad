/* Coefficients in parameters, and resultants. */
#include "bridge.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "facts.h"
#include "flint_ends.h"
#include "mem.h"
#include "mpoly_take.h"

enum { MOST_TERMS = 400, RESULTANT_TERMS = 60, RESULTANT_DEGREE = 12 };

void poly_coefficients_clear(struct poly_coefficients *c)
{
    free(c->coefficient);
    free(c->of);
    *c = (struct poly_coefficients){ 0 };
}

/* What a coefficient belongs to: the exponents of what moves. */
struct monomial {
    ulong *exp;
    fmpz_mpoly_t sum;
    unsigned of;
};

static bool moves(const struct poly_bridge *b, int g)
{
    return b->gen[g].depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME);
}

static struct monomial *place_of(const struct poly_bridge *b, struct monomial *m, int *count, const ulong *exp)
{
    size_t bytes = (size_t)b->max_gens * sizeof *exp;
    for (int i = 0; i < *count; i++)
        if (memcmp(m[i].exp, exp, bytes) == 0)
            return m + i;
    struct monomial *n = m + (*count)++;
    n->exp = memcpy(sga_malloc(bytes), exp, bytes);
    n->of = 0;
    for (int g = 0; g < b->gens; g++)
        if (exp[g])
            n->of |= b->gen[g].depends;
    fmpz_mpoly_init(n->sum, b->ctx);
    return n;
}

static void collect(struct poly_bridge *b, const fmpz_mpoly_t f, struct poly_coefficients *out)
{
    SGA_ARENA(mem);
    struct monomial *m = sga_take(&mem, ((size_t)f->length + 1) * sizeof *m);
    ulong *moving = sga_zeros(&mem, (size_t)b->max_gens, sizeof *moving), *fixed = sga_zeros(&mem, (size_t)b->max_gens, sizeof *fixed);
    int count = 0;
    for (slong i = 0; i < f->length; i++) {
        poly_exponents(b, f, i, fixed);
        for (int g = 0; g < b->max_gens; g++) {
            bool out_of = g < b->gens && moves(b, g);
            moving[g] = out_of ? fixed[g] : 0;
            fixed[g] = out_of ? 0 : fixed[g];
        }
        struct monomial *at = place_of(b, m, &count, moving);
        fmpz_mpoly_push_term_fmpz_ui(at->sum, f->coeffs + i, fixed, b->ctx);
    }
    out->coefficient = sga_malloc(((size_t)count + 1) * sizeof *out->coefficient);
    out->of = sga_malloc(((size_t)count + 1) * sizeof *out->of);
    for (int i = 0; i < count; i++) {
        fmpz_mpoly_sort_terms(m[i].sum, b->ctx);
        out->coefficient[out->count] = poly_show_poly(b, m[i].sum);
        out->of[out->count++] = m[i].of;
        fmpz_mpoly_clear(m[i].sum, b->ctx);
        free(m[i].exp);
    }
}

struct poly_numerator {
    struct poly_bridge *b;
    struct poly_fraction f;
};

struct poly_numerator *poly_numerator_new(struct expr_store *st, expr_id e, const struct poly_limits *limits)
{
    struct sga_error before = *st->error;
    struct poly_numerator *n = sga_calloc(1, sizeof *n);
    n->b = e ? poly_bridge_new(st, &e, 1, limits) : NULL;
    const struct poly_ratio *r = n->b ? poly_value(n->b, e) : NULL;
    if (!r || !poly_fraction_of(n->b, r, &n->f)) {
        poly_bridge_free(n->b);
        free(n);
        n = NULL;
    }
    *st->error = before;
    return n;
}

void poly_numerator_free(struct poly_numerator *n)
{
    if (!n)
        return;
    poly_fraction_clear(n->b, &n->f);
    poly_bridge_free(n->b);
    free(n);
}

expr_id poly_numerator_shown(struct poly_numerator *n)
{
    struct poly_bridge *b = n->b;
    fmpz_mpoly_t f;
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    expr_id e = expr_int(b->st, 0);
    if (!n->f.num->length)
        return e;
    fmpz_mpoly_init(f, b->ctx);
    poly_content(c, n->f.num);
    if (fmpz_sgn(n->f.num->coeffs) < 0)
        fmpz_neg(c, c);
    fmpz_mpoly_scalar_divexact_fmpz(f, n->f.num, c, b->ctx);
    e = poly_show_poly(b, f);
    fmpz_mpoly_clear(f, b->ctx);
    return e;
}

bool poly_coefficients_of(struct poly_numerator *n, struct poly_coefficients *out)
{
    struct expr_store *st = n->b->st;
    struct sga_error before = *st->error;
    *out = (struct poly_coefficients){ 0 };
    if (n->f.num->length > MOST_TERMS)
        return false;
    collect(n->b, n->f.num, out);
    bool ok = expr_store_ok(st);
    *st->error = before;
    if (!ok)
        poly_coefficients_clear(out);
    return ok;
}

int poly_generator_of(const struct poly_bridge *b, expr_id node)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    int at = -1;
    bool inside = false;
    expr_cone_init(&cone);
    for (int g = 0; g < b->gens; g++) {
        if (b->gen[g].node == node) {
            at = g;
            continue;
        }
        if (b->gen[g].op == EXPR_SYM)
            continue;
        expr_cone_of(b->st, &cone, &b->gen[g].node, 1);
        for (int i = 0; i < cone.count; i++)
            inside = inside || cone.list[i] == node;
    }
    return inside ? -1 : at;
}

static bool small(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    return f->length <= RESULTANT_TERMS && poly_degree(b, f) <= RESULTANT_DEGREE;
}

bool poly_resultant(struct expr_store *st, expr_id x, expr_id y, int symbol, const struct poly_limits *limits, expr_id *out)
{
    struct sga_error before = *st->error;
    struct poly_fraction f, g;
    expr_id roots[2] = { x, y };
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(st, roots, 2, limits);
    const struct poly_ratio *p = b ? poly_value(b, x) : NULL, *q = b ? poly_value(b, y) : NULL;
    bool ok = p && q;
    int at = ok ? poly_generator_of(b, st->symbol[symbol].node) : -1;
    if (at >= 0 && poly_fraction_of(b, p, &f)) {
        ok = poly_fraction_of(b, q, &g);
        if (ok) {
            SGA_ARENA(mem);
            fmpz_mpoly_struct *r = mpoly_take(&mem, b->ctx);
            ok = small(b, f.num) && small(b, g.num) && fmpz_mpoly_resultant(r, f.num, g.num, at, b->ctx) && poly_fits(b, r);
            if (ok)
                *out = poly_show_poly(b, r);
            poly_fraction_clear(b, &g);
        }
        poly_fraction_clear(b, &f);
        ok = ok && expr_store_ok(st);
    } else {
        ok = false;
    }
    *st->error = before;
    return ok;
}

bool poly_powers_of(struct poly_numerator *n, expr_id node, expr_id **coefficient, int *degree)
{
    struct poly_bridge *b = n->b;
    struct sga_error before = *b->st->error;
    int at = poly_generator_of(b, node);
    *coefficient = NULL;
    *degree = -1;
    if (at < 0)
        return false;
    slong top = fmpz_mpoly_degree_si(n->f.num, at, b->ctx), var = at;
    assert(!fmpz_mpoly_is_zero(n->f.num, b->ctx) || top < 0);
    *coefficient = sga_malloc(((size_t)(top < 0 ? 0 : top) + 1) * sizeof **coefficient);
    SGA_ARENA(mem);
    fmpz_mpoly_struct *c = mpoly_take(&mem, b->ctx);
    for (slong k = 0; k <= top; k++) {
        ulong power = (ulong)k;
        fmpz_mpoly_get_coeff_vars_ui(c, n->f.num, &var, &power, 1, b->ctx);
        (*coefficient)[k] = poly_show_poly(b, c);
    }
    *degree = (int)top;
    bool ok = expr_store_ok(b->st);
    *b->st->error = before;
    if (!ok) {
        free(*coefficient);
        *coefficient = NULL;
    }
    return ok;
}
