/* Sums of magnitudes: what cancels in a value leaves its roundings. */
#include "told.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "ball.h"
#include "mem.h"

enum { BITS = 64 };

/* Of a node, from its children's values and magnitudes. */
static double magnitude(const struct expr_store *st, const struct expr_cone *cone, int k, const double *value, const double *large)
{
    const struct expr_node n = st->node[cone->list[k]];
    switch ((enum expr_op)n.op) {
    case EXPR_ADD: case EXPR_SUB: return large[cone->place[n.a]] + large[cone->place[n.b]];
    case EXPR_NEG: return large[cone->place[n.a]];
    case EXPR_MUL: return fmax(large[cone->place[n.a]] * fabs(value[cone->place[n.b]]), fabs(value[cone->place[n.a]]) * large[cone->place[n.b]]);
    case EXPR_DIV: return large[cone->place[n.a]] / fabs(value[cone->place[n.b]]);
    default: return fabs(value[k]);
    }
}

double told_rounding(const struct sys_system *sys, expr_id e, const double *in)
{
    const struct expr_store *st = sys->store;
    struct expr_cone cone;
    struct num_ball b;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    expr_cone_index(&cone);
    num_ball_init(&b, st, BITS);
    for (int j = 0; j <= sys->variables; j++)
        num_ball_set_d(&b, j < sys->variables ? sys->variable[j].symbol : sys->time, in[j]);
    num_ball_list(&b, cone.list, cone.count);
    double *value = sga_malloc((2 * (size_t)cone.count + 1) * sizeof *value), *large = value + cone.count;
    for (int k = 0; k < cone.count; k++) {
        value[k] = arf_get_d(arb_midref(num_ball_value(&b, cone.list[k])), ARF_RND_NEAR);
        large[k] = magnitude(st, &cone, k, value, large);
    }
    double rounding = DBL_EPSILON * large[cone.count - 1];
    free(value);
    num_ball_clear(&b);
    expr_cone_clear(&cone);
    return isfinite(rounding) ? rounding : 0;
}
