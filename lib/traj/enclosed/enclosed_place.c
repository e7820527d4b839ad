/* A start that was searched for, in balls: see struct enclosed_found. */
#include "enclosed.h"

#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "mem.h"
#include "system.h"
#include "table.h"
#include "table_balls.h"
#include "trajectory.h"

/* No bound is passed for sure: which of them the start lies on has been solved for. */
static bool within(const struct enclosed_found *found, arb_srcptr x)
{
    SGA_ENDS(arb_end) arb_t bound = { 0 };
    bool in = true;
    for (int j = 0; j < found->sys->variables && found->low && in; j++) {
        arb_set_d(bound, found->low[j]);
        in = !arb_lt(x + j, bound);
        arb_set_d(bound, found->high[j]);
        in &= !arb_gt(x + j, bound);
    }
    return in;
}

/* Tables among those nodes have their values at t. */
static bool set_tables(const struct sys_system *sys, struct num_ball *b, const struct expr_cone *cone, const arb_t t, slong prec)
{
    const struct expr_store *st = sys->store;
    SGA_ENDS(arb_end) arb_t v = { 0 };
    bool ok = true;
    for (int k = 0; k < cone->count && ok; k++) {
        const struct expr_node *n = st->node + cone->list[k];
        struct expr_table *table = n->op == EXPR_SYM ? st->symbol[n->a].table : NULL;
        ok = !table || num_table_around(v, table, st->symbol[n->a].order, t, prec + 20);
        if (table)
            num_ball_set(b, n->a, v);
    }
    return ok;
}

bool enclosed_values(const struct sys_system *sys, const arb_t t, arb_srcptr x, const expr_id *function, int count, slong prec, arb_ptr out)
{
    struct num_ball b;
    num_ball_init(&b, sys->store, prec + 20);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(sys->store, &cone, function, count);
    for (int j = 0; j < sys->variables; j++)
        num_ball_set(&b, sys->variable[j].symbol, x + j);
    num_ball_set(&b, sys->time, t);
    bool ok = set_tables(sys, &b, &cone, t, prec);
    num_ball_list(&b, cone.list, cone.count);
    for (int i = 0; i < count && ok; i++) {
        arb_set(out + i, num_ball_value(&b, function[i]));
        ok = arb_is_finite(out + i);
    }
    num_ball_clear(&b);
    return ok;
}

/* What follows from the others is 0 there, to the bits of x. */
static bool agree(const struct enclosed_found *found, const arb_t t0, slong prec, arb_srcptr x)
{
    SGA_ARENA(mem);
    arb_ptr v = arbs_take(&mem, found->alsos);
    bool all = enclosed_values(found->sys, t0, x, found->also, found->alsos, prec, v);
    for (int i = 0; i < found->alsos && all; i++)
        all = arb_contains_zero(v + i);
    return all;
}

static bool refuse(struct sga_error *err, const char *place, const char *what, slong prec)
{
    sga_fail_at(err, SGA_E_INITIAL, place, what, (long)prec);
    memcpy(err->stage, "initial", 8);
    return false;
}

bool enclosed_place(const struct enclosed_found *found, const struct enclose_problem *problem, const arb_t t0, slong prec, arb_ptr x, struct sga_error *err)
{
    const struct sys_system *sys = found->sys;
    SGA_FREED int *variable = field_inputs(sys);
    SGA_ARENA(mem);
    arb_ptr whole = arbs_take(&mem, sys->variables);
    struct enclose_problem p = { .st = sys->store, .variable = variable, .n = sys->variables, .time = sys->time, .tables = problem->tables, .budget = problem->budget };
    if (!enclosed_start(found->flow, sys, &p, found->with, found->asked, found->near, t0, prec, whole, err))
        return false;
    if (!within(found, whole))
        return refuse(err, "/trajectory/bounds", "the start lies on a bound as far as doubles tell, and beyond it with %ld bits; give wider bounds", prec);
    if (found->alsos && !agree(found, t0, prec, whole))
        return refuse(err, "/trajectory/start_equations", "an equation of the start follows from the others as far as doubles tell, and not with %ld bits: they touch there, or have tables; leave it out", prec);
    for (int j = 0; j < problem->n; j++)
        for (int k = 0; k < sys->variables; k++)
            if (variable[k] == problem->variable[j])
                arb_set(x + j, whole + k);
    return true;
}
