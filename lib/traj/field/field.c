/* Evaluation of the reduced field, by its expressions or by its defining rows; what is watched on the way is
 * field_watch.c's. */
#include "field.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "gauge_choice.h"
#include "jacobian.h"
#include "larger.h"
#include "lin_sparse.h"
#include "mem.h"
#include "ode.h"
#include "points_space.h"
#include "pole_named.h"
#include "reduction.h"
#include "stages.h"
#include "switches.h"
#include "system.h"
#include "tape.h"
#include "warnings.h"
#include "whole.h"

int *field_inputs(const struct sys_system *sys)
{
    int n = sys->variables, *inputs = sga_malloc((size_t)(n + 1) * sizeof *inputs);
    for (int j = 0; j < n; j++)
        inputs[j] = sys->variable[j].symbol;
    inputs[n] = sys->time;
    return inputs;
}

/* Constraints have come behind it, and may carry it. */
static bool is_deep(const struct sga_solution *sol, int pivot)
{
    return sol->pivot[pivot].generation <= sol->generations;
}

/* What is watched: sides, pivots of the reduction, determinants, pivots of the gauge choice. */
static struct num_tape *direct_tape(struct field *f, const struct sga_solution *sol, const int *inputs, struct sga_error *err)
{
    struct expr_store *st = f->sys->store;
    struct field_list l = { 0 };
    for (int j = 0; j < f->n; j++)
        field_list_add(&l, f->root[j]);
    for (int i = 0; i < sol->sides; i++)       /* first: beyond these the answer does not hold */
        field_list_add(&l, sol->side[i].function);
    f->sides = sol->sides;
    for (int q = 0; q < sol->pivots; q++)
        if (is_deep(sol, q) && !expr_is_const(st, sol->pivot[q].value))
            field_watch_pivot(f, sol->pivot[q].value, &l);
    f->deep = l.count - f->n;
    for (int q = 0; q < sol->pivots; q++)
        if (!is_deep(sol, q) && !expr_is_const(st, sol->pivot[q].value))
            field_watch_pivot(f, sol->pivot[q].value, &l);
    for (int q = 0; q < sol->dense_blocks; q++)
        field_list_add(&l, sol->determinant[q].value);
    f->chosen = l.count - f->n;
    for (int q = 0; q < f->choice->pivots; q++)
        field_list_add(&l, f->choice->pivot[q]);
    f->pivots = l.count - f->n;
    field_find_poles(f, &l);
    f->poles = l.count - f->n - f->pivots;
    struct num_tape *t = num_tape_new_switched(st, field_switches(f), l.e, l.count, inputs, f->n + 1, err);
    if (l.count > f->n)
        memmove(l.e, l.e + f->n, (size_t)(l.count - f->n) * sizeof *l.e);
    f->pivot_expr = l.e;
    f->pole_expr = l.e + f->pivots;
    return t;
}

static struct num_tape *general_tape(struct field *f, const int *inputs, struct sga_error *err)
{
    const struct sys_system *sys = f->sys;
    expr_id *root;
    int at = sys_expressions(sys, &root);
    root = sga_realloc(root, (size_t)(at + f->rates + 1) * sizeof *root);
    for (int k = 0; k < f->rates; k++)
        root[at++] = f->rate[k].rate;
    at = field_sums_add(f, &root, at);
    struct num_tape *t = num_tape_new_switched(sys->store, field_switches(f), root, at, inputs, f->n + 1, err);
    f->general_out = sga_malloc((size_t)(at + 1) * sizeof *f->general_out);
    free(root);
    return t;
}

/* Those of events too: |x| comes to 0 on its kink. */
static void find_switches(struct field *f, const struct traj_request *rq, const expr_id *con)
{
    expr_id *root;
    int at = sys_expressions(f->sys, &root);
    root = sga_realloc(root, (size_t)(at + f->n + f->c + f->rates + rq->events + 1) * sizeof *root);
    for (int j = 0; j < f->n; j++)
        root[at++] = f->root[j];
    for (int i = 0; i < f->c; i++)
        root[at++] = con[i];
    for (int k = 0; k < f->rates; k++)
        root[at++] = f->rate[k].rate;
    for (int k = 0; k < rq->events; k++)
        root[at++] = rq->event[k].expression;
    num_switches_find(f->switches, f->sys->store, root, at);
    free(root);
}

bool field_sane(const struct field *f)
{
    bool lists = 0 <= f->sides && f->sides <= f->deep && f->deep <= f->chosen && f->chosen <= f->pivots && f->poles >= 0;
    bool lost = f->lost_pivot >= -1 && f->lost_pivot < f->pivots && f->lost_pole >= -1 && f->lost_pole < f->poles && f->fell >= -1 && f->fell < f->chosen;
    return lists && lost && f->beyond >= -1 && f->beyond < f->sides && f->generic_rank >= 0 && f->generic_rank <= f->n && f->rank <= f->n;
}

const struct num_switches *field_switches(const struct field *f)
{
    return f->switches->count ? f->switches : NULL;
}

bool field_init(struct field *f, const struct sys_system *sys, const struct sga_solution *sol,
                const struct traj_request *rq, struct manifold *manifold, struct sga_error *err)
{
    int n = sys->variables, c = sol->constraints;
    *f = (struct field){ .solution_side = sol->side, .n = n, .rows = sys->rows, .c = c, .rates = rq->rates, .rate = rq->rate, .guess = rq->initial, .given = rq->given, .valued = rq->valued, .valueds = rq->valueds, .sys = sys, .rank = -1,
                         .manifold = manifold, .lost_pivot = -1, .lost_pole = -1, .fell = -1, .border = -1, .beyond = -1, .generic_rank = n - sol->free_columns,
                         .switches = sga_calloc(1, sizeof *f->switches), .choice = sga_calloc(1, sizeof *f->choice) };
    gauge_choice_make(f->choice, sys, sol, rq);
    f->fast = !f->choice->why;
    if (f->choice->field && n > SGA_MOST_ROWS_ASKED && !f->choice->pivots)
        sga_limit_met(rq->budget, SGA_LIMIT_ROWS_ASKED);
    f->root = f->choice->field ? f->choice->field : sol->field;
    int *inputs = field_inputs(sys);
    expr_id *con = sga_malloc((size_t)(c + 1) * sizeof *con);
    for (int i = 0; i < c; i++)
        con[i] = sol->constraint[i].expr;
    bool ok = true;
    find_switches(f, rq, con);
    f->direct = direct_tape(f, sol, inputs, err);
    f->direct_out = sga_malloc((size_t)(n + f->pivots + f->poles + 1) * sizeof(double));
    f->stages = sga_calloc((size_t)(f->pivots + f->poles) * ODE_CODE_CALLS + 1, sizeof *f->stages);
    f->pivot_start = sga_calloc((size_t)f->pivots + 1, sizeof(double));
    f->pivot_side = sga_calloc((size_t)f->pivots + 1, sizeof(double));
    f->pole_side = sga_calloc((size_t)f->poles + 1, sizeof(double));
    f->pole_from = sga_calloc((size_t)n + 1, sizeof(double));
    f->here = sga_calloc((size_t)n + 1, sizeof(double));
    f->home = sga_calloc((size_t)(n + f->pivots + f->poles) + 1, sizeof(double));
    ok = f->direct != NULL;
    if (ok)
        f->general = general_tape(f, inputs, err);
    if (ok && f->valueds)
        ok = (f->values = num_tape_new(sys->store, f->valued, f->valueds, inputs, n + 1, err)) != NULL;
    if (ok && f->general)
        f->con = num_tape_new_switched(sys->store, field_switches(f), con, c, inputs, n + 1, err);
    if (f->con)
        f->jac = num_jacobian_new(f->con, NULL, 0);
    free(inputs);
    f->constraint = con;
    for (int q = 0; q < sol->dense_blocks; q++)
        f->dense = sol->determinant[q].size > f->dense ? sol->determinant[q].size : f->dense;
    if (!f->jac)
        return false;
    f->jac_value = sga_malloc((size_t)(f->jac->nnz + 1) * sizeof(double));
    f->in = sga_malloc((size_t)(n + 1) * sizeof(double));
    assert(field_sane(f) && num_tape_roots(f->direct) == n + f->pivots + f->poles);
    return true;
}

void field_keep_held(const struct field *f, const signed char *side, struct traj_result *r)
{
    size_t count = side ? (size_t)f->switches->count : 0;
    r->helds = (int)count;
    r->held_argument = sga_malloc((count + 1) * sizeof *r->held_argument);
    r->held = sga_malloc(count + 1);
    for (size_t k = 0; k < count; k++) {
        r->held_argument[k] = f->switches->argument[k];
        r->held[k] = side[k];
    }
}

void field_hold(struct field *f, const signed char *side)
{
    f->along_t = NAN;
    num_tape_hold(f->direct, side);
    num_tape_hold(f->general, side);
    num_jacobian_hold(f->jac, side);
    if (f->guard)
        num_tape_hold(f->guard, side);
    if (f->slope)
        num_jacobian_hold(f->slope, side);
}

void field_clear(struct field *f)
{
    whole_free(f->whole);
    free((expr_id *)f->constraint);
    num_jacobian_free(f->jac);
    num_tape_free(f->con);
    num_tape_free(f->values);
    pole_named_free(f->named);
    num_tape_free(f->direct);
    num_tape_free(f->general);
    num_jacobian_free(f->alpha_slope);
    num_tape_free(f->alpha);
    num_jacobian_free(f->slope);
    num_tape_free(f->plain);
    lin_sparse_free(f->pattern);
    gauge_choice_clear(f->choice);
    free(f->choice);
    num_switches_clear(f->switches);
    free(f->switches);
    free(f->direct_out);
    free(f->stages);
    free(f->pivot_start);
    free(f->pivot_expr);
    free(f->pivot_side);
    free(f->pole_side);
    free(f->pole_from);
    free(f->here);
    free(f->home);
    field_guards_forget(f);
    free(f->general_out);
    free(f->alpha_value);
    free(f->sum);
    free(f->jac_value);
    free(f->in);
    free(f->M);
    free(f->rhs);
    free(f->qr);
    free(f->kept);
    free(f->perm);
    *f = (struct field){ 0 };
}

void field_load(struct field *f, double t, const double *x)
{
    sga_copy(f->in, x, f->n);
    f->in[f->n] = t;
}

double field_size(const struct field *f, const double *v)
{
    double size = 1;
    for (int j = 0; j < f->n; j++)
        size = sga_larger(size, fabs(v[j]) / (f->unit ? f->unit[j] : 1));
    return size;
}

bool field_value(struct field *f, double *v)
{
    int rank;
    if (!f->fast)
        return field_general(f, v, &rank);
    memcpy(v, f->direct_out, (size_t)f->n * sizeof *v);
    for (int j = 0; j < f->n; j++)
        if (!isfinite(v[j]))
            return false;
    return true;
}

bool field_code(struct field *f, struct ode_code *code)
{
    struct num_code c;
    if (!f->fast || !num_tape_code(f->direct, f->n, &c))
        return false;
    *code = (struct ode_code){ c.run, c.slots, c.time, f->stages, (size_t)(f->pivots + f->poles) };
    return true;
}

bool field_stages(struct field *f, const struct sga_stages *plan, struct sga_stage_code *code)
{
    if (!f->fast || !num_tape_stages(f->direct, f->n, plan, code))
        return false;
    code->rest = f->stages;
    return true;
}

bool field_code_holds(const struct field *f, int calls)
{
    bool ok = true;
    int watched = f->pivots + f->poles;
    for (int i = 0; watched && i < calls; i++)
        ok &= field_well_inside(f, f->stages + (size_t)i * (size_t)watched);
    return ok;
}

bool field_eval(struct field *f, double t, const double *x, double *v)
{
    f->evaluations++;
    f->rank_lost = false;
    if (f->whole) {
        int told;
        if (t == f->start_t) {
            field_along_anew(f);
            field_keep_sides(f, t, x);
        }
        field_load(f, t, x);
        bool known = field_general(f, v, &told);
        f->rank_lost = known && told < f->rank;
        return known && !f->rank_lost;
    }
    bool finite = num_tape_eval_field(f->direct, x, t, f->n, v, f->direct_out + f->n);
    if (t == f->start_t)
        field_take_sides(f, t, x);
    if (finite && field_well_inside(f, f->direct_out + f->n)) {
        if (f->pivots || f->poles) {
            sga_copy(f->here, x, f->n);
            f->here_t = t;
        }
        return true;
    }
    if ((f->pivots || f->poles) && !field_inside(f, t, x)) {
        f->rank_lost = f->lost_pole < 0;
        f->contradiction = false;
        return false;
    }
    if (f->fast && finite && field_pivots_well(f))
        return true;
    int rank, row = 0;
    field_load(f, t, x);
    bool has = field_general(f, v, &rank);
    f->rank_lost = has && rank < f->rank;
    if (!has || f->rank_lost || !f->rates) {
        f->contradiction &= has && !f->rank_lost;
        return has && !f->rank_lost;
    }
    bool miss = field_rows_miss(f, v, &row) > 1e-6 * field_size(f, v);
    f->contradiction |= miss;
    return !miss;
}
