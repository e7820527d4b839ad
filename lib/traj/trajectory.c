/* A trajectory from request to samples. */
#include "trajectory.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "arithmetic.h"
#include "budget.h"
#include "charts.h"
#include "defined.h"
#include "enclosed.h"
#include "endings.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "gauge_choice.h"
#include "given_rows.h"
#include "inputs.h"
#include "jumps.h"
#include "mem.h"
#include "oracle.h"
#include "reduction.h"
#include "seeds.h"
#include "sizes.h"
#include "start_relations.h"
#include "warnings.h"

/* Of the whole way: a motion that comes so much further with other pivots goes on. */
static const double FURTHER = 1e-6;

/* The changes of the motion that was made last. */
static void keep_charts(struct flow *f, struct traj_result *r)
{
    const struct charts *q = f->charts;
    r->chart = sga_calloc((size_t)q->changes + 1, sizeof *r->chart);
    for (r->charts = 0; r->charts < q->changes; r->charts++)
        r->chart[r->charts] = (struct traj_chart){ q->change[r->charts].t, charts_pivot(f, q->change + r->charts) };
}

static bool further(const struct traj_request *rq, const struct traj_result *next, const struct traj_result *r)
{
    double way = fabs(rq->times[rq->samples - 1] - rq->start);
    return !next->ended || next->ended_event >= 0 || fabs(next->ended_t - rq->start) > fabs(r->ended_t - rq->start) + FURTHER * way;
}

/* Where a pivot comes to 0 the motion is made once more, with a chart more. Where that was not seen on the way, but the motion ended there, it is
 * what comes further that is kept. */
static bool solve_in_charts(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                            struct traj_result *r, struct sga_error *err)
{
    struct traj_result before = { 0 };
    bool had = false;
    size_t n = (size_t)f->n;
    double *start = memcpy(sga_malloc((n + 1) * sizeof *start), r->initial, n * sizeof *start), moved = r->moved;
    bool ok = field_slope_init(f->field, err);
    if (ok)
        charts_init(f, sol, rq);
    for (;;) {
        struct sga_error failed = { 0 };
        ok = ok && in_arithmetic(f, sys, sol, rq, r, had ? &failed : err);
        bool stopped = ok && f->charts && f->charts->stop;
        if (had && !stopped && (!ok || !further(rq, r, &before))) {
            traj_result_clear(r);
            *r = before;
            ok = sga_budget_ok(rq->budget, err);
            break;
        }
        if (had && !stopped) {
            traj_result_clear(&before);
            had = false;
        }
        if (!ok || (!stopped && (!ended_by_pivots(r) || !charts_add(f)))) {
            if (ok && f->charts && f->charts->count > 1)
                keep_charts(f, r);
            break;
        }
        if (stopped)
            traj_result_clear(r);
        else {
            before = *r;
            had = true;
        }
        charts_again(f);
        *r = (struct traj_result){ .initial = memcpy(sga_malloc((n + 1) * sizeof *start), start, n * sizeof *start), .moved = moved };
    }
    free(start);
    return ok;
}

const char *traj_gauge_text(bool conditions, bool rates, bool least_norm)
{
    static const char *const text[2][2][2] = {
        { { "none", "least norm" }, { "rates", "rates, then least norm" } },
        { { "conditions", "conditions, then least norm" }, { "conditions and rates", "conditions and rates, then least norm" } },
    };
    return text[conditions][rates][least_norm];
}

/* A motion on the equations as they stand that ended is made once more by the reduced field, which watches what it divides by: what comes further is
 * kept, but where that finds a stratum the motion ends there. Larger ones would take too long. */
static bool solve_as_reduced(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                             struct traj_result *r)
{
    struct sga_error ignored = { 0 };
    struct traj_result again = { .moved = r->moved };
    if (!f->field->whole || f->n > SGA_MOST_ROWS_ASKED || !ended_by_pivots(r) || !field_as_reduced(f->field, rq->start, r->initial, &ignored))
        return true;
    again.initial = memcpy(sga_malloc(((size_t)f->n + 1) * sizeof *again.initial), r->initial, (size_t)f->n * sizeof *again.initial);
    if (!solve_in_charts(f, sys, sol, rq, &again, &ignored) || (again.ended && !again.stratum && fabs(again.ended_t - rq->start) < 0.999 * fabs(r->ended_t - rq->start))) {
        traj_result_clear(&again);
        return sga_budget_ok(rq->budget, &ignored);
    }
    traj_result_clear(r);
    *r = again;
    return true;
}

/* A place a little beyond the end of a motion. */
struct beyond { double t, *x; };

/* Where it ended at a side beyond which constraints were not found to hold. */
static void look_beyond(struct flow *f, const struct traj_result *r, struct beyond *b)
{
    static const double AHEAD = 1e-3;         /* of the time passed */
    struct field *q = f->field;
    if (!r->stratum || q->lost_pivot < 0 || q->lost_pivot >= q->sides || q->fell >= 0)
        return;
    size_t n = (size_t)f->n;
    double step = AHEAD * (r->ended_t - q->begin_t);
    SGA_FREED double *v = sga_malloc((n + 1) * sizeof *v);
    field_forget_trial(q);
    if (!field_eval(q, q->home_t, q->home, v))
        return;
    b->t = q->home_t + step;
    b->x = sga_malloc((n + 1) * sizeof *b->x);
    for (size_t j = 0; j < n; j++)
        b->x[j] = q->home[j] + step * v[j];
}

static bool run_as_is(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                      struct traj_result *r, struct beyond *beyond, struct sga_error *err)
{
    struct flow f;
    *r = (struct traj_result){ 0 };
    bool ok = flow_init(&f, sys, sol, rq, err);
    if (ok) {
        r->initial = sga_calloc((size_t)f.n + 1, sizeof *r->initial);
        ok = flow_start(&f, sys, sol, rq, r->initial, &r->moved, err) && flow_given(&f, rq, r->initial, err)
             && field_begin(f.field, rq->start, r->initial, err);
        if (ok && rq->arithmetic == TRAJ_BALL) {
            double begin = sga_cpu();
            ok = enclosed_run(&f, sys, sol, rq, r, err);
            r->seconds = sga_cpu() - begin;
        } else if (ok) {
            ok = solve_in_charts(&f, sys, sol, rq, r, err) && (solve_as_reduced(&f, sys, sol, rq, r) || sga_budget_ok(rq->budget, err));
        }
    }
    if (ok && beyond)
        look_beyond(&f, r, beyond);
    if (ok) {
        if (f.sizes->any)
            r->unit = memcpy(sga_malloc(((size_t)r->columns + 1) * sizeof *r->unit), f.sizes->column, (size_t)r->columns * sizeof *r->unit);
        r->inputs_examined = f.inputs->complete || rq->arithmetic == TRAJ_BALL;
        r->gauge = flow_gauge(&f, rq);
        r->gauge_numeric = f.field->choice->why;
    } else if (!err->stage[0]) {
        memcpy(err->stage, "trajectory", 11);
    }
    flow_clear(&f);
    if (!ok)
        traj_result_clear(r);
    return ok;
}

/* What constraints were found to be by one side of a switch, others may say by another: of max(x, 0) max(y, 0) = 0 either does. The motion that the reduction beyond the
 * end allows is kept where it comes further. */
static void by_other_sides(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, const struct beyond *beyond, struct traj_result *r)
{
    struct sga_error ignored = { 0 };
    struct sga_solution own;
    struct points_oracle oracle;
    struct traj_result again;
    struct reduction_options options = { .near = beyond->x, .near_time = beyond->t, .near_pivots = true, .seed = SGA_SEED_CHART, .budget = rq->budget, .gauge_fields = sol->free_columns > 0 };
    points_oracle_init(&oracle, SGA_SEED_CHART);
    bool ok = sga_reduce(sys, &options, &oracle, &own, &ignored);
    ok = ok && own.verdict == sol->verdict && own.constraints == sol->constraints && own.free_columns == sol->free_columns && !own.specials
         && run_as_is(sys, &own, rq, &again, NULL, &ignored);
    if (ok && further(rq, &again, r)) {
        struct traj_result ended = *r;
        *r = again;
        again = ended;
    }
    if (ok)
        traj_result_clear(&again);
    sga_solution_clear(&own);
    points_oracle_clear(&oracle);
}

static bool run_by_sides(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err)
{
    struct beyond beyond = { 0 };
    bool ok = run_as_is(sys, sol, rq, r, &beyond, err);
    if (ok && beyond.x)
        by_other_sides(sys, sol, rq, &beyond, r);
    free(beyond.x);
    return ok;
}

/* The start may lie where a pivot of the reduction is 0 and the rank stays: then that of other pivots is tried. */
static bool run_from_start(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                           struct traj_result *r, struct sga_error *err)
{
    struct sga_error first = { 0 }, ignored = { 0 };
    struct sga_solution own;
    struct points_oracle oracle;
    if (run_by_sides(sys, sol, rq, r, &first))
        return true;
    bool may = first.code == SGA_E_INITIAL || first.code == SGA_E_NO_MOTION, ok = false;
    if (may && charts_solve_at_start(sys, sol, rq, &own, &oracle)) {
        ok = run_as_is(sys, &own, rq, r, NULL, &ignored);
        sga_solution_clear(&own);
        points_oracle_clear(&oracle);
    }
    if (!ok)
        *err = first;
    return ok;
}

/* It ended at a singular position: the motion in pieces may pass it, in the same arithmetic. */
static void go_through(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r)
{
    struct traj_result through;
    struct traj_request q = *rq;
    struct sga_error ignored = { 0 };
    bool may = r->stratum && !rq->ends_there && !rq->single && !rq->turns && rq->arithmetic != TRAJ_BALL;
    if (may && rq->arithmetic == TRAJ_AUTO && strcmp(r->arithmetic, "double-double") == 0)
        q.arithmetic = TRAJ_DOUBLE_DOUBLE;
    if (!may || !jumps_run(sys, sol, &q, &through, &ignored))
        return;
    if (through.passes && !(through.out_of_time && through.rows < r->rows)) {
        struct traj_result ended = *r;
        *r = through;
        through = ended;
    }
    traj_result_clear(&through);
}

static bool run_once(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                     struct traj_result *r, struct sga_error *err)
{
    struct defined d;
    bool all = sol->definitions == sys->variables;       /* balls need something that moves */
    if (!defined_any(sol, rq) || (all && rq->arithmetic == TRAJ_BALL))
        return run_from_start(sys, sol, rq, r, err);
    *r = (struct traj_result){ 0 };
    defined_init(&d, sys, sol, rq);
    bool ok = defined_start(&d, err) && run_by_sides(&d.system, &d.solution, &d.request, r, err);
    if (ok) {
        r->initial = defined_lift(&d, r->initial);
        r->moved = defined_moved(&d, r->initial, r->moved);
        ok = defined_in_doubles(&d, r->initial, err);
        if (!ok)
            traj_result_clear(r);
    }
    defined_clear(&d);
    return ok;
}

/* Constraints that hold so well are no reason to ask the equations. */
static const double SURE_RESIDUAL = 1e-9;

static bool run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                struct traj_result *r, struct sga_error *err)
{
    if (start_relations_any(rq))
        return start_relations_run(sys, sol, rq, r, err);
    if (traj_in_pieces(rq))
        return jumps_run(sys, sol, rq, r, err);
    bool ok = run_once(sys, sol, rq, r, err);
    if (ok && !(r->residual <= SURE_RESIDUAL) && !given_rows_hold(sys, rq, r->initial, err)) {
        memcpy(err->stage, "trajectory", 11);
        traj_result_clear(r);
        ok = false;
    }
    if (ok)
        go_through(sys, sol, rq, r);
    return ok;
}

bool traj_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
              struct traj_result *r, struct sga_error *err)
{
    bool ok = run(sys, sol, rq, r, err);
    assert(!ok || traj_result_sane(rq, r));
    return ok;
}
