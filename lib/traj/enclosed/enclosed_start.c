/* What a ball trajectory starts from, and the field it follows. */
#include "enclosed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "ball.h"
#include "budget.h"
#include "derive.h"
#include "error.h"
#include "field.h"
#include "flint_ends.h"
#include "flow.h"
#include "gauge_choice.h"
#include "mem.h"
#include "points_space.h"
#include "reduction.h"
#include "system.h"
#include "trajectory.h"

/* The proved point may be this far from where double arithmetic came to rest, beside 1 + |x|. */
static const double SAME_POINT = 1e-6;

/* Arguments of signs in the constraints, each once; malloced: where one changes its sign a constraint jumps, of which the field, its derivative, says nothing. */
static expr_id *jumping(const struct expr_store *st, const struct sga_solution *sol, int *count)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED expr_id *root = sga_malloc((size_t)(sol->constraints + 1) * sizeof *root);
    expr_cone_init(&cone);
    for (int i = 0; i < sol->constraints; i++)
        root[i] = sol->constraint[i].expr;
    expr_cone_of(st, &cone, root, sol->constraints);
    expr_id *list = sga_malloc((size_t)(cone.count + 1) * sizeof *list);
    *count = 0;
    for (int k = 0; k < cone.count; k++)
        if (expr_op_of(st, cone.list[k]) == EXPR_SIGN)
            list[(*count)++] = st->node[cone.list[k]].a;
    return list;
}

bool enclosed_problem(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                      struct enclose_problem *p, struct sga_error *err)
{
    int n = f->n, *variable = field_inputs(sys);
    const struct gauge_choice *choice = f->field->choice;
    expr_id *field = memcpy(sga_malloc((size_t)(n + 1) * sizeof *field), f->field->root, (size_t)n * sizeof *field);
    int jumps;
    SGA_FREED expr_id *jump = jumping(sys->store, sol, &jumps);
    expr_id *nonzero = sga_malloc((size_t)(sol->sides + sol->pivots + sol->dense_blocks + choice->pivots + jumps + 1) * sizeof *nonzero);
    *p = (struct enclose_problem){ .st = sys->store, .variable = variable, .n = n, .time = sys->time, .field = field,
                                   .nonzero = nonzero, .budget = rq->budget };
    for (int i = 0; i < sol->sides; i++)
        nonzero[p->nonzeros++] = sol->side[i].function;
    for (int i = 0; i < sol->pivots; i++)
        if (!expr_is_const(sys->store, sol->pivot[i].value))
            nonzero[p->nonzeros++] = sol->pivot[i].value;
    for (int i = 0; i < sol->dense_blocks; i++)
        nonzero[p->nonzeros++] = sol->determinant[i].value;
    for (int i = 0; i < choice->pivots; i++)
        nonzero[p->nonzeros++] = choice->pivot[i];
    for (int i = 0; i < jumps; i++)
        nonzero[p->nonzeros++] = jump[i];
    if (!choice->why || choice->field)      /* what is lost in double is not lost here */
        return true;
    bool rates = sol->gauge || !sol->free_columns;
    return sga_fail_at(err, SGA_E_NOT_SUPPORTED, rates ? "/trajectory/gauge/rates" : "/accuracy/arithmetic", "%s; ball arithmetic needs "
                       "the field as expressions: give %strajectory.gauge.conditions, or use \"double\"", choice->why, rates ? "other rates, " : "");
}

void enclosed_problem_clear(struct enclose_problem *p)
{
    free((int *)p->variable);
    free((expr_id *)p->field);
    free((expr_id *)p->nonzero);
    *p = (struct enclose_problem){ 0 };
}

static bool not_proved(struct sga_error *err, slong prec)
{
    if (err->code != SGA_E_OK)
        return false;
    sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial", "interval Newton with %ld bits cannot prove that there is one consistent start near "
                "the projected initial values; start where the constraints are regular", (long)prec);
    memcpy(err->stage, "initial", 8);
    return false;
}

static bool same_point(arb_srcptr x, const double *near, int n)
{
    for (int j = 0; j < n; j++)
        if (!(fabs(arf_get_d(arb_midref(x + j), ARF_RND_NEAR) - near[j]) <= SAME_POINT * (1 + fabs(near[j]))))
            return false;
    return true;
}

/* No value that was given is another one now. */
static bool as_given(const struct enclose_problem *p, const struct traj_request *rq, const double *near, slong prec, arb_srcptr x)
{
    bool as = true;
    arb_t g;
    arb_init(g);
    for (int j = 0; j < p->n && as; j++) {
        if (!rq->given[j])
            continue;
        num_ball_constant(p->st, rq->exact_initial ? rq->exact_initial[j] : EXPR_UNDEF, rq->initial[j], prec, g);
        as = near[j] == rq->initial[j] && arb_overlaps(x + j, g);
    }
    arb_clear(g);
    return as;
}

/* The one unknown of e, whose slope by it is a constant: the place of its variable, and its value where e is 0, a constant; -1: it is not so. */
static int linear_in_one(struct expr_store *st, const struct enclose_problem *p, const unsigned char *solved, expr_id e, expr_id *value)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    int one = -1, unknowns = 0;
    expr_cone_init(&cone);
    for (int j = 0; j < p->n && unknowns < 2; j++)
        if (solved[j] && expr_depends(st, &cone, e, p->variable[j])) {
            one = j;
            unknowns++;
        }
    expr_id at = e, slope = unknowns == 1 ? expr_diff(st, e, p->variable[one]) : EXPR_UNDEF;
    if (!slope || !expr_is_const(st, slope) || expr_is_zero(st, slope))
        return -1;
    SGA_FREED expr_id *map = sga_calloc((size_t)st->symbols + 1, sizeof *map);
    map[p->variable[one]] = expr_int(st, 0);
    expr_substitute(st, &e, 1, map);
    *value = e ? expr_neg(st, expr_div(st, e, slope)) : EXPR_UNDEF;
    if (!*value || !expr_is_const(st, *value))
        return -1;
    map[p->variable[one]] = *value;
    expr_substitute(st, &at, 1, map);       /* what jumps has the same slope on both sides */
    return at && expr_is_zero(st, at) ? one : -1;
}

/* A rational constant: e, or what the ball is; EXPR_UNDEF: neither is one. */
static expr_id exact_constant(struct expr_store *st, expr_id e, const arb_t x)
{
    SGA_ENDS(fmpq_end) fmpq_t q = { { 0, 1 } };
    if (e && expr_is_const(st, e))
        return e;
    if (e || !arb_is_exact(x))
        return EXPR_UNDEF;
    arf_get_fmpq(q, arb_midref(x));
    return expr_fmpq(st, q);
}

/* An unknown of e that has a value, where e is 0 at known values: it is that value; -1: there is none. */
static int met_by(struct expr_store *st, const struct enclose_problem *p, const unsigned char *solved, const expr_id *known, const expr_id *map, expr_id e)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED expr_id *all = sga_malloc(((size_t)st->symbols + 1) * sizeof *all);
    int one = -1;
    expr_cone_init(&cone);
    memcpy(all, map, (size_t)st->symbols * sizeof *all);
    for (int j = 0; j < p->n; j++)
        if (solved[j] && known[j] && expr_is_const(st, known[j])) {
            all[p->variable[j]] = known[j];
            one = expr_depends(st, &cone, e, p->variable[j]) ? j : one;
        }
    expr_substitute(st, &e, 1, all);
    return e && expr_is_zero(st, e) ? one : -1;
}

/* Where a switch stands at its 0 because values that are known make others so, those are known exactly, and solved for no more: a ball around them would not tell. known: by variable
 * the constant that it is, or EXPR_UNDEF: its ball is it, where that is exact; start: that of time. function, their count and x are what is left; the others have the known
 * values put in. */
static void put_exact(struct expr_store *st, const struct enclose_problem *p, expr_id start, const expr_id *known, const arb_t t0, slong prec, unsigned char *solved, expr_id *function,
                      int *functions, arb_ptr x)
{
    SGA_FREED expr_id *map = sga_calloc((size_t)st->symbols + 1, sizeof *map);
    map[p->time] = exact_constant(st, start, t0);
    for (int j = 0; j < p->n; j++)
        if (!solved[j])
            map[p->variable[j]] = exact_constant(st, known[j], x + j);
    expr_substitute(st, function, *functions, map);
    for (bool more = true; more && expr_store_ok(st);) {
        more = false;
        for (int i = 0; i < *functions; i++) {
            expr_id value;
            int j = function[i] ? met_by(st, p, solved, known, map, function[i]) : -1;
            if (j >= 0)
                value = known[j];
            else
                j = function[i] ? linear_in_one(st, p, solved, function[i], &value) : -1;
            if (j < 0)
                continue;
            solved[j] = 0;
            arb_set_fmpq(x + j, expr_const_value(st, value), prec);
            map[p->variable[j]] = value;
            function[i] = function[--*functions];
            expr_substitute(st, function, *functions, map);
            more = true;
        }
    }
}

/* Coordinates of Pf are kept, the other variables solved for. */
static bool solve_others(struct flow *f, const struct enclose_problem *p, const struct sga_solution *sol, const struct traj_request *rq,
                         const double *near, const arb_t t0, slong prec, arb_ptr x, struct sga_error *err)
{
    int n = f->n, c = sol->constraints, all = c, open = 0;
    unsigned char *solved = sga_calloc((size_t)n + 1, 1);
    expr_id *function = sga_malloc((size_t)(c + 1) * sizeof *function);
    SGA_FREED expr_id *known = sga_calloc((size_t)n + 1, sizeof *known);
    for (int j = 0; j < n; j++) {
        bool kept = rq->given[j] && rq->exact_initial && near[j] == rq->initial[j];
        known[j] = kept ? rq->exact_initial[j] : EXPR_UNDEF;
        num_ball_constant(p->st, known[j], near[j], prec, x + j);
    }
    for (int i = 0; i < c; i++)
        function[i] = sol->constraint[i].expr;
    for (int j = 0; j < n && rq->asked; j++)
        open += solved[j] = !rq->held[j];
    if (open != c) {
        memset(solved, 0, (size_t)n);
        open = flow_solved(f, rq, near, solved);
    }
    if (open == c && expr_has_branches(p->st, function, c))
        put_exact(f->sys->store, p, rq->exact_initial ? rq->exact_start : EXPR_UNDEF, known, t0, prec, solved, function, &c, x);
    bool ok = open == all && expr_store_ok(p->st) && (!c || enclose_zero(p, function, c, t0, solved, prec, x, err)) && same_point(x, near, n);
    free(solved);
    free(function);
    return ok;
}

bool enclosed_start(struct flow *f, const struct sys_system *sys, const struct enclose_problem *p, const struct sga_solution *sol,
                    const struct traj_request *rq, const double *near, const arb_t t0, slong prec, arb_ptr x, struct sga_error *err)
{
    bool nearest = rq->asked && rq->asked->nearest;
    bool ok = !nearest && solve_others(f, p, sol, rq, near, t0, prec, x, err), as = ok && (!sol->constraints || as_given(p, rq, near, prec, x));
    if (rq->asked && !nearest)
        ok = as;
    else if (sol->constraints && err->code == SGA_E_OK && !as) {
        arb_ptr u = _arb_vec_init(f->n);
        if (enclosed_nearest(sys, p, sol, rq, f->sizes, near, t0, prec, u) && same_point(u, near, f->n)) {
            _arb_vec_set(x, u, f->n);
            ok = true;
        }
        _arb_vec_clear(u, f->n);
    }
    if (!ok && sga_budget_ok(rq->budget, err))      /* what failed may have been stopped */
        not_proved(err, prec);
    return ok;
}
