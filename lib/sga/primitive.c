/* Common denominators of combinations, and what of them is missing in the candidates that they make. */
#include "primitive.h"

#include <stdlib.h>

#include "arena.h"
#include "budget.h"
#include "facts.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "state.h"
#include "system.h"
#include "warnings.h"

/* A product of powers of factors that may vanish with the variables or time. */
struct powers {
    struct { expr_id factor; long power; } *at;
    int count;
    size_t cap;
};

static bool may_vanish(struct state *s, expr_id e)
{
    unsigned f = state_facts(s, e);
    return f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME) && !(f & EXPR_NONZERO);
}

/* Whether a pivot that may vanish went into c. */
static bool divided(struct state *s, const struct candidate *c)
{
    bool any = false;
    SGA_FREED unsigned char *in = sga_calloc((size_t)s->ech.pivots + 1, 1);
    for (int k = 0; k < c->ops; k++)
        in[c->op[k].pivot] = 1;
    for (int q = s->ech.pivots - 1; q >= 0 && !any; q--) {
        if (!in[q])
            continue;
        any = may_vanish(s, s->ech.pivot[q].value);
        for (int k = 0; k < s->ech.pivot[q].row.ops; k++)
            in[s->ech.pivot[q].row.op[k].pivot] = 1;
    }
    return any;
}

static long *power_of(struct powers *p, expr_id factor)
{
    for (int i = 0; i < p->count; i++)
        if (p->at[i].factor == factor)
            return &p->at[i].power;
    SGA_RESERVE(p->at, p->cap, p->count + 1);
    p->at[p->count].factor = factor;
    p->at[p->count].power = 0;
    return &p->at[p->count++].power;
}

/* From so many nodes on a combination may be made of sums that cancel: its normal form takes its place where it is smaller by this much. */
enum { SWOLLEN = 20, SMALLER = 2 };

/* The denominator of e joins the common one, with factors that vanish nowhere if `all`. False: over budget. */
static bool denominator(struct state *s, expr_id e, const struct poly_limits *limits, bool all, struct powers *p)
{
    SGA_ENDS(poly_factors_clear) struct poly_factors f = { 0 };
    if (!poly_denominator_factors(s->st, e, limits, &f))
        return false;
    for (int i = 0; i < f.factors; i++) {
        const struct poly_factor *q = f.factor + i;
        if ((q->never_zero && !all) || !(q->depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
            continue;
        long *power = power_of(p, q->expr);
        if (q->multiplicity > *power)
            *power = q->multiplicity;
    }
    return true;
}

/* The common denominator of the vector, of full length and without common factors when multiplied by it. False: over budget. */
static bool common_denominator(struct state *s, const struct candidate *c, const struct poly_limits *limits, bool all, expr_id *product)
{
    struct powers p = { 0 };
    SGA_FREED struct sga_part *part = NULL;
    int parts;
    state_combine(s, c, &part, &parts);
    bool ok = expr_store_ok(s->st);
    for (int i = 0; i < parts && ok; i++)
        ok = denominator(s, part[i].factor, limits, all, &p) && sga_budget_ok(s->options->budget, NULL);
    *product = expr_int(s->st, 1);
    for (int i = 0; i < p.count && ok; i++)
        *product = expr_mul(s->st, *product, expr_powi(s->st, p.at[i].factor, p.at[i].power));
    free(p.at);
    return ok;
}

/* Where sums in c cancel: what is left of them, if that is so much smaller. */
static void shrink(struct state *s, struct candidate *c, const struct poly_limits *limits)
{
    int size = state_size(s, c->expr);
    expr_id common, whole;
    if (size < SWOLLEN || !common_denominator(s, c, limits, true, &common)
        || !poly_normal(s->st, expr_mul(s->st, common, c->expr), limits, &whole) || SMALLER * state_size(s, whole) > size)
        return;
    c->expr = c->base = whole;
    c->order = 0;
    if (!expr_is_one(s->st, common))
        c->times = common;
}

void primitive_candidate(struct state *s, struct candidate *c)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, s->options->budget);
    expr_id common, whole;
    if (!c->ops || s->ech.blocks)
        return;
    bool may = divided(s, c);
    if (s->sys->variables > SGA_MOST_LOST_PARTS_VARIABLES) {
        if (may)
            sga_limit_met(s->options->budget, SGA_LIMIT_LOST_PARTS_VARIABLES);
        return;
    }
    if (!may) {
        shrink(s, c, &limits);
        return;
    }
    if (!common_denominator(s, c, &limits, false, &common) || !poly_normal(s->st, expr_mul(s->st, common, c->expr), &limits, &whole))
        return;
    if (expr_is_one(s->st, common)) {
        SGA_ENDS(poly_factors_clear) struct poly_factors f = { 0 };      /* poles that cancel are none of the constraint */
        if (!poly_denominator_factors(s->st, c->expr, &limits, &f))
            return;
        bool none = !f.factors;
        if (none)
            c->expr = c->base = whole;
        return;
    }
    c->expr = c->base = whole;
    c->order = 0;
    c->times = common;
}
