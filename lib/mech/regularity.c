/* Where the rank of H along W drops.
 *
 * Every way of eliminating H divides by pivots, and where the rank drops some pivot of each way vanishes: so factors
 * of the pivots that were used are places to look at, and if none of them can vanish the rank is full everywhere. A pivot
 * may vanish where the rank holds, though; points with c^T H = 0 and |c| = 1 are what is really meant, and are looked for by
 * themselves. */
#include "drops.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "form.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"

enum { GRAM_AT_MOST = 3 };

static struct poly_limits limits_of(const struct mech_search *s)
{
    return poly_limits_of(POLY_AMPLE, s->options->budget);
}

static bool never_zero(struct mech_search *s, expr_id e)
{
    return (expr_is_const(s->st, e) && !expr_is_zero(s->st, e)) || expr_facts_of(&s->facts, s->st, e) & EXPR_NONZERO;
}

static void add_factor(struct mech_search *s, expr_id e)
{
    if (never_zero(s, e))
        return;
    s->all_never_zero = false;
    for (int i = 0; i < s->factors; i++)
        if (s->factor[i] == e)
            return;
    SGA_RESERVE(s->factor, s->factor_cap, s->factors + 1);
    s->factor[s->factors++] = e;
}

/* Parameters left symbolic are taken as general. */
static void factors_of(struct mech_search *s, expr_id pivot)
{
    struct poly_limits limits = limits_of(s);
    struct poly_factors f;
    if (never_zero(s, pivot))
        return;
    if (!poly_numerator_factors(s->st, pivot, &limits, &f)) {
        add_factor(s, pivot);
        return;
    }
    for (int i = 0; i < f.factors; i++)
        if (!f.factor[i].never_zero && f.factor[i].depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME))
            add_factor(s, f.factor[i].expr);
    poly_factors_clear(&f);
}

/* Positive numbers (parameters are taken as positive) on the diagonal: then M is positive definite, and only
 * H can fail. */
static bool masses_simple(struct mech_search *s)
{
    bool simple = true;
    for (size_t k = 0; k < s->in->masses && simple; k++) {
        const struct form_entry *e = s->in->mass + k;
        unsigned flags = expr_facts_of(&s->facts, s->st, e->value);
        if (e->row != e->col)
            simple = expr_is_zero(s->st, e->value);
        else if (expr_is_const(s->st, e->value))
            simple = fmpq_sgn(expr_const_value(s->st, e->value)) > 0;
        else
            simple = expr_op_of(s->st, e->value) == EXPR_SYM && !(flags & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME));
    }
    return simple;
}

/* det(H H^T), the sum of the squares of all minors, by permutations: few conditions only. */
static expr_id gram_determinant(const struct mech_search *s)
{
    struct expr_store *st = s->st;
    expr_id G[GRAM_AT_MOST][GRAM_AT_MOST];
    for (int i = 0; i < s->m; i++)
        for (int k = 0; k < s->m; k++) {
            G[i][k] = expr_int(st, 0);
            for (int j = 0; j < s->n; j++)
                G[i][k] = expr_add(st, G[i][k], expr_mul(st, mech_entry(s, i, j), mech_entry(s, k, j)));
        }
    if (s->m == 1)
        return G[0][0];
    expr_id det = expr_int(st, 0);
    if (s->m == 2)
        return expr_sub(st, expr_mul(st, G[0][0], G[1][1]), expr_mul(st, G[0][1], G[1][0]));
    for (int i = 0; i < 3; i++) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        expr_id minor = expr_sub(st, expr_mul(st, G[1][a], G[2][b]), expr_mul(st, G[1][b], G[2][a]));
        det = expr_add(st, det, expr_mul(st, G[0][i], minor));
    }
    return det;
}

/* The pivots belong to the functions that the reduction took; an irregular one was replaced. */
static bool pivots_are_of_H(const struct mech_search *s)
{
    bool plain = true;
    for (int i = 0; i < s->f->W->constraints; i++)
        plain = plain && !s->f->W->constraint[i].replaced;
    return plain || !s->f->own;
}

/* Where a condition has no derivative a proof by its differential says nothing. */
static bool has_kinks(const struct mech_search *s)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    bool kinks = false;
    expr_cone_init(&cone);
    expr_cone_of(s->st, &cone, s->f->condition, s->m);
    for (int i = 0; i < cone.count && !kinks; i++) {
        enum expr_op op = expr_op_of(s->st, cone.list[i]);
        kinks = op == EXPR_ABS || op == EXPR_SIGN || op == EXPR_MIN || op == EXPR_MAX || op == EXPR_CBRT;
    }
    return kinks;
}

static bool proved_full(struct mech_search *s)
{
    struct poly_limits limits = limits_of(s);
    struct poly_factors f;
    bool full = true;
    if (!s->simple || s->f->W->branches || has_kinks(s))
        return false;
    if (s->all_never_zero && !s->f->W->dense_blocks && pivots_are_of_H(s))
        return true;
    if (s->m > GRAM_AT_MOST || !poly_numerator_factors(s->st, gram_determinant(s), &limits, &f))
        return false;
    for (int i = 0; i < f.factors; i++)
        full = full && (f.factor[i].never_zero || !(f.factor[i].depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)));
    full = full && f.sign != 0;
    poly_factors_clear(&f);
    return full;
}

void mech_regularity_find(struct mech_regularity *r, struct mech_fibre *f, const struct form_mechanical *in,
                          const struct reduction_options *options)
{
    assert(f->W && f->conditions >= 0);
    struct mech_search s = { .r = r, .f = f, .in = in, .options = options, .st = f->kinematics.store, .all_never_zero = true,
                        .n = in->coordinates, .m = f->conditions };
    *r = (struct mech_regularity){ .full = MECH_FULL_PROVED };
    expr_facts_init(&s.facts);
    s.simple = masses_simple(&s);
    for (int q = 0; q < f->W->pivots; q++)
        factors_of(&s, f->W->pivot[q].value);
    if (!proved_full(&s)) {
        r->full = MECH_FULL_SEARCHED;
        mech_search_factors(&s);
        if (!r->point)
            mech_search_kernels(&s);
    }
    expr_facts_clear(&s.facts);
    free(s.factor);
}

void mech_regularity_clear(struct mech_regularity *r)
{
    free(r->point);
    free(r->where);
    *r = (struct mech_regularity){ 0 };
}
