/* Zero or not, and shape in one symbol. */
#include "arena.h"
#include "bridge.h"

static bool any_kernel(const struct poly_bridge *b)
{
    for (int g = 0; g < b->gens; g++)
        if (b->gen[g].op != EXPR_SYM && b->gen[g].op != EXPR_PI)
            return true;
    return false;
}

enum poly_truth poly_bridge_is_zero(struct poly_bridge *b, expr_id e)
{
    const struct poly_ratio *r = poly_value(b, e);
    if (!r)
        return POLY_UNKNOWN;
    struct poly_ratio u;
    poly_ratio_init(b, &u);
    poly_ratio_set(b, &u, r);
    enum poly_truth t = POLY_UNKNOWN;
    if (poly_reduce_ratio(b, &u)) {
        if (fmpz_mpoly_is_zero(u.num, b->ctx))
            t = POLY_YES;
        else if (!any_kernel(b))
            t = POLY_NO;
    }
    poly_ratio_clear(b, &u);
    return t;
}

enum poly_truth poly_is_zero(struct expr_store *st, expr_id e, const struct poly_limits *limits)
{
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(st, &e, 1, limits);
    return b ? poly_bridge_is_zero(b, e) : POLY_UNKNOWN;
}

/* The generator of a symbol, or -1 if it does not occur. */
static int generator_of(const struct poly_bridge *b, int symbol)
{
    for (int g = 0; g < b->gens; g++)
        if (b->gen[g].op == EXPR_SYM && b->gen[g].node == b->st->symbol[symbol].node)
            return g;
    return -1;
}

static bool below_kernel(struct poly_bridge *b, int g, const fmpz_mpoly_t f, struct expr_cone *cone)
{
    bool inside = false;
    for (int k = 0; k < b->gens && !inside; k++) {
        if (b->gen[k].op == EXPR_SYM || b->gen[k].op == EXPR_PI || fmpz_mpoly_degree_si(f, k, b->ctx) <= 0)
            continue;
        expr_cone_of(b->st, cone, &b->gen[k].node, 1);
        for (int i = 0; i < cone->count; i++)
            inside = inside || cone->list[i] == b->gen[g].node;
    }
    return inside;
}

/* e as a fraction whose denominator and kernels are free of the symbol; *g its generator
 * (-1: it does not occur). On success the caller clears f. */
static bool polynomial_in(struct poly_bridge *b, expr_id e, int symbol, struct poly_fraction *f, int *g)
{
    const struct poly_ratio *r = poly_value(b, e);
    if (!r || !poly_fraction_of(b, r, f))
        return false;
    *g = generator_of(b, symbol);
    if (*g < 0)
        return true;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    bool ok = !below_kernel(b, *g, f->num, &cone) && fmpz_mpoly_degrees_fit_si(f->num, b->ctx);
    for (int i = 0; ok && i < f->dens; i++)
        ok = fmpz_mpoly_degree_si(f->den[i].f, *g, b->ctx) == 0 && !below_kernel(b, *g, f->den[i].f, &cone);
    if (!ok)
        poly_fraction_clear(b, f);
    return ok;
}

static long degree_of(const struct poly_bridge *b, const struct poly_fraction *f, int g)
{
    if (f->num->length == 0)
        return -1;
    return g < 0 ? 0 : fmpz_mpoly_degree_si(f->num, g, b->ctx);
}

bool poly_degree_in(struct expr_store *st, expr_id e, int symbol, const struct poly_limits *limits, long *degree)
{
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(st, &e, 1, limits);
    struct poly_fraction f;
    int g;
    bool ok = b && polynomial_in(b, e, symbol, &f, &g);
    if (ok) {
        *degree = degree_of(b, &f, g);
        poly_fraction_clear(b, &f);
    }
    return ok;
}

bool poly_linear_in(struct expr_store *st, expr_id e, int symbol, const struct poly_limits *limits, expr_id line[2])
{
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(st, &e, 1, limits);
    struct poly_fraction f;
    int g;
    bool ok = b && polynomial_in(b, e, symbol, &f, &g);
    if (ok) {
        ok = degree_of(b, &f, g) <= 1;
        for (int k = 0; ok && k < 2; k++) {
            struct poly_fraction part = f;
            slong power = 1 - k;
            fmpz_mpoly_init(part.num, b->ctx);
            if (g < 0 && k == 1)
                fmpz_mpoly_set(part.num, f.num, b->ctx);
            else if (g >= 0)
                fmpz_mpoly_get_coeff_vars_ui(part.num, f.num, (slong[]){ g }, (ulong[]){ (ulong)power }, 1, b->ctx);
            ok = poly_show(b, &part, line + k);
            fmpz_mpoly_clear(part.num, b->ctx);
        }
        poly_fraction_clear(b, &f);
    }
    return ok;
}
