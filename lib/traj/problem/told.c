/* Sums of magnitudes: what cancels in a value leaves its roundings. */
#include "told.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "definition.h"
#include "mem.h"
#include "signals.h"
#include "system.h"

enum { BITS = 64 };
/* What is solved for has more roundings than what is evaluated. */
static const double SOLVED = 4;

/* Of a node, from its children's values and magnitudes. */
static double magnitude(const struct expr_store *st, const struct expr_cone *cone, int k, const double *value, const double *large)
{
    const struct expr_node n = st->node[cone->list[k]];
    assert(k == 0 || cone->list[k - 1] < cone->list[k]);       /* children come first */
    switch ((enum expr_op)n.op) {
    case EXPR_ADD: case EXPR_SUB: return large[cone->place[n.a]] + large[cone->place[n.b]];
    case EXPR_NEG: return large[cone->place[n.a]];
    case EXPR_MUL: return fmax(large[cone->place[n.a]] * fabs(value[cone->place[n.b]]), fabs(value[cone->place[n.a]]) * large[cone->place[n.b]]);
    case EXPR_DIV: return large[cone->place[n.a]] / fabs(value[cone->place[n.b]]);
    default: return fabs(value[k]);
    }
}

/* Of e at the place. cone: whose walk it is; names: or NULL. */
static double magnitude_of(struct told_place *t, const struct definitions *names, struct expr_cone *cone, expr_id e)
{
    const struct expr_store *st = t->sys->store;
    expr_cone_of(st, cone, &e, 1);
    expr_cone_index(cone);
    num_ball_list(&t->at, cone->list, cone->count);
    SGA_FREED double *value = sga_malloc((2 * (size_t)cone->count + 1) * sizeof *value);
    double *large = value + cone->count;
    for (int k = 0; k < cone->count; k++)
        value[k] = arf_get_d(arb_midref(num_ball_value(&t->at, cone->list[k])), ARF_RND_NEAR);
    for (int k = 0; k < cone->count; k++) {
        large[k] = magnitude(st, cone, k, value, large);
        for (int i = 0; names && i < names->count; i++)
            if (expr_op_of(st, cone->list[k]) == EXPR_SYM && st->node[cone->list[k]].a == t->sys->variable[names->at[i].variable].symbol) {
                SGA_ENDS(expr_cone_clear) struct expr_cone own;
                expr_cone_init(&own);
                large[k] = fmax(large[k], SOLVED * magnitude_of(t, NULL, &own, names->at[i].value));
            }
    }
    return large[cone->count - 1];
}

void told_begin(struct told_place *t, const struct sys_system *sys, const struct definitions *names, const double *in)
{
    *t = (struct told_place){ .sys = sys, .names = names };
    num_ball_init(&t->at, sys->store, BITS);
    expr_cone_init(&t->cone);
    for (int j = 0; j <= sys->variables; j++)
        num_ball_set_d(&t->at, j < sys->variables ? sys->variable[j].symbol : sys->time, in[j]);
    signals_set(sys, in[sys->variables], &t->at);
}

void told_end(struct told_place *t)
{
    num_ball_clear(&t->at);
    expr_cone_clear(&t->cone);
}

double told_rounding(struct told_place *t, expr_id e)
{
    double rounding = DBL_EPSILON * magnitude_of(t, t->names, &t->cone, e);
    return isfinite(rounding) ? rounding : 0;
}
