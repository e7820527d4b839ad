/* Functions that have no derivative on the set, as such that have one and are equal there. */
#include "definition_flat.h"

#include <assert.h>
#include <stdlib.h>

#include "ball.h"
#include "derive.h"
#include "mem.h"
#include "op.h"
#include "oracle.h"
#include "points.h"
#include "system.h"

/* Whether the node's branch changes at the point: a derivative by one side of it says nothing. */
static bool changes(const struct definitions *d, const struct sys_system *sys, struct num_ball *b, const struct expr_node n)
{
    if (n.op != EXPR_ABS && n.op != EXPR_SIGN && n.op != EXPR_MIN && n.op != EXPR_MAX)
        return false;
    bool two = n.op == EXPR_MIN || n.op == EXPR_MAX;
    expr_id of[2] = { n.a, two ? n.b : expr_int(sys->store, 0) };
    definitions_through(d, sys, of, 2);
    num_ball_extend(b);
    return arb_overlaps(num_ball_value(b, of[0]), num_ball_value(b, of[1]));
}

static bool has_gradient(const struct definitions *d, const struct sys_system *sys, struct num_ball *b, expr_id e)
{
    struct expr_store *st = sys->store;
    unsigned char *active = sga_calloc((size_t)st->symbols + 1, 1);
    struct expr_cone cone;
    struct expr_term *term = NULL;
    size_t cap = 0;
    bool all = true;
    expr_cone_init(&cone);
    for (int j = 0; j < sys->variables; j++)
        active[sys->variable[j].symbol] = 1;
    int terms = expr_gradient(st, &cone, e, active, &term, &cap);
    for (int k = 0; k < terms && all; k++) {
        expr_id slope = term[k].value;
        definitions_through(d, sys, &slope, 1);
        num_ball_extend(b);
        all = arb_is_finite(num_ball_value(b, slope));
    }
    expr_cone_clear(&cone);
    free(term);
    free(active);
    return all;
}

bool definition_smooth(const struct definitions *d, const struct sys_system *sys, struct points_oracle *oracle, expr_id e)
{
    struct num_ball *b = &oracle->real[0].ball;
    struct expr_cone cone;
    bool smooth = true;
    expr_cone_init(&cone);
    expr_cone_of(sys->store, &cone, &e, 1);
    for (int k = 0; k < cone.count && smooth; k++)
        smooth = !changes(d, sys, b, sys->store->node[cone.list[k]]);
    expr_cone_clear(&cone);
    return smooth && has_gradient(d, sys, b, e);
}

static bool vanishes(struct points_oracle *oracle, expr_id e)
{
    num_ball_extend(&oracle->real[0].ball);
    if (!arb_contains_zero(num_ball_value(&oracle->real[0].ball, e)))
        return false;
    struct points_decision z = points_oracle_zero(oracle, e);
    return z.truth == POINTS_ZERO && (z.basis == POINTS_ZERO_ALGEBRAIC || z.basis == POINTS_EXACT);
}

/* What a function keeps where its argument stays at an end of where it has values; UNDEF where it does not. */
static expr_id at_end(struct expr_store *st, struct points_oracle *oracle, const struct expr_node n)
{
    const enum expr_op op = (enum expr_op)n.op;
    const struct expr_interval *domain = expr_op_domain(op), *values = expr_op_values(op);
    bool grows = expr_op_traits(op) & EXPR_GROWS;
    assert(domain->closed);
    if (domain->has_high && vanishes(oracle, expr_sub(st, n.a, expr_interval_end(st, domain, true))))
        return expr_interval_end(st, values, grows);
    if (domain->has_low && vanishes(oracle, expr_sub(st, n.a, expr_interval_end(st, domain, false))))
        return expr_interval_end(st, values, !grows);
    return EXPR_UNDEF;
}

/* The value that the node keeps on the set, as a function that has derivatives; UNDEF where it does not stay at an end. */
static expr_id end_of(struct expr_store *st, struct points_oracle *oracle, expr_id e)
{
    const struct expr_node n = st->node[e];
    switch ((enum expr_op)n.op) {
    case EXPR_ABS: case EXPR_SIGN: case EXPR_CBRT:
        return vanishes(oracle, n.a) ? expr_int(st, 0) : EXPR_UNDEF;
    case EXPR_POW:         /* x^0 is another matter */
        return vanishes(oracle, n.a) && vanishes(oracle, e) ? expr_int(st, 0) : EXPR_UNDEF;
    case EXPR_MIN: case EXPR_MAX:
        return vanishes(oracle, expr_sub(st, n.a, n.b)) ? n.a : EXPR_UNDEF;
    default:
        return expr_op_domain((enum expr_op)n.op)->closed ? at_end(st, oracle, n) : EXPR_UNDEF;
    }
}

/* By node of the store: what takes the place of those of the cone. malloced. */
static expr_id *ends_of(struct expr_store *st, struct points_oracle *oracle, const struct expr_cone *cone)
{
    expr_id *end = sga_calloc((size_t)cone->count + 1, sizeof *end);
    for (int k = 0; k < cone->count; k++)
        end[k] = end_of(st, oracle, cone->list[k]);
    expr_id *by = sga_calloc((size_t)st->nodes + 1, sizeof *by);       /* questions made nodes: only now is it known how many */
    for (int k = 0; k < cone->count; k++)
        by[cone->list[k]] = end[k];
    free(end);
    return by;
}

expr_id definition_flattened(const struct definitions *d, const struct sys_system *sys, struct points_oracle *oracle, expr_id f)
{
    struct expr_store *st = sys->store;
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &f, 1);
    expr_id *by = ends_of(st, oracle, &cone), flat = expr_replace(st, f, by);
    free(by);
    expr_cone_clear(&cone);
    return flat && definition_smooth(d, sys, oracle, flat) ? flat : f;
}
