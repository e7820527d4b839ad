/* What a ball trajectory starts from, and the field it follows. */
#include "enclosed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ball.h"
#include "budget.h"
#include "field.h"
#include "flow.h"
#include "gauge_choice.h"
#include "mem.h"
#include "points_space.h"
#include "reduction.h"
#include "system.h"
#include "trajectory.h"

/* The proved point may be this far from where double arithmetic came to rest, beside 1 + |x|. */
static const double SAME_POINT = 1e-6;

void enclosed_constant(const struct expr_store *st, expr_id e, double otherwise, slong prec, arb_t r)
{
    if (e == EXPR_UNDEF) {
        arb_set_d(r, otherwise);
        return;
    }
    if (expr_is_const(st, e)) {
        arb_set_fmpq(r, expr_const_value(st, e), prec);
        return;
    }
    struct num_ball b;
    struct expr_cone cone;
    num_ball_init(&b, st, prec);
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    num_ball_list(&b, cone.list, cone.count);
    arb_set(r, num_ball_value(&b, e));
    expr_cone_clear(&cone);
    num_ball_clear(&b);
}

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
    const struct gauge_choice *choice = &f->field.choice;
    expr_id *field = memcpy(sga_malloc((size_t)(n + 1) * sizeof *field), f->field.root, (size_t)n * sizeof *field);
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
        enclosed_constant(p->st, rq->exact_initial ? rq->exact_initial[j] : EXPR_UNDEF, rq->initial[j], prec, g);
        as = near[j] == rq->initial[j] && arb_overlaps(x + j, g);
    }
    arb_clear(g);
    return as;
}

/* Coordinates of Pf are kept, the other variables solved for. */
static bool solve_others(struct flow *f, const struct enclose_problem *p, const struct sga_solution *sol, const struct traj_request *rq,
                         const double *near, const arb_t t0, slong prec, arb_ptr x, struct sga_error *err)
{
    int n = f->n, c = sol->constraints, open = 0;
    unsigned char *solved = sga_calloc((size_t)n + 1, 1);
    expr_id *function = sga_malloc((size_t)(c + 1) * sizeof *function);
    for (int j = 0; j < n; j++) {
        bool kept = rq->given[j] && rq->exact_initial && near[j] == rq->initial[j];
        enclosed_constant(p->st, kept ? rq->exact_initial[j] : EXPR_UNDEF, near[j], prec, x + j);
    }
    for (int i = 0; i < c; i++)
        function[i] = sol->constraint[i].expr;
    for (int j = 0; j < n && rq->asked; j++)
        open += solved[j] = !rq->held[j];
    if (open != c) {
        memset(solved, 0, (size_t)n);
        open = flow_solved(f, rq, near, solved);
    }
    bool ok = !c || (open == c && enclose_zero(p, function, c, t0, solved, prec, x, err) && same_point(x, near, n));
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
