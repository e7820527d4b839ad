/* A trajectory from request to samples. */
#include "trajectory.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "charts.h"
#include "defined.h"
#include "enclosed.h"
#include "endings.h"
#include "flow.h"
#include "given_rows.h"
#include "inputs.h"
#include "jumps.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "precise.h"
#include "reduction.h"
#include "redundant.h"
#include "rows_kept.h"
#include "sizes.h"
#include "start_relations.h"
#include "system.h"
#include "tape.h"
#include "tolerance.h"
#include "warnings.h"

/* Where a motion ends at a place that was located to a tolerance, a sample nearer to it than that cannot be said to
 * lie before it. */
static void drop_at_end(const struct traj_request *rq, struct ode_result *o)
{
    enum ode_reason why = o->end.reason;
    double near = rq->rtol * fmax(fabs(o->end.t), fabs(o->end.t - rq->start));
    if (why != ODE_BLOW_UP && why != ODE_LEFT_DOMAIN && why != ODE_CONSTRAINT_LOST && why != ODE_SINGULAR)
        return;
    while (o->count > 1 && fabs(rq->times[o->count - 1] - o->end.t) <= near)
        o->count--;
    if (!o->error)
        return;
    o->max_error = 0;
    for (int i = 0; i < o->count; i++)
        o->max_error = fmax(o->max_error, o->error[i]);
}

/* Keep the outputs of the samples, or all variables. */
static void keep(struct flow *f, const struct traj_request *rq, const struct ode_result *o, struct traj_result *r)
{
    r->columns = rq->outputs ? rq->outputs : f->n;
    r->rows = o->count;
    r->t = sga_malloc((size_t)(o->count + 1) * sizeof *r->t);
    r->value = sga_malloc((size_t)(o->count + 1) * (size_t)(r->columns + 1) * sizeof *r->value);
    for (int i = 0; i < o->count; i++) {
        const double *x = o->samples + (size_t)i * (size_t)f->n;
        r->t[i] = rq->times[i];
        if (rq->outputs)
            flow_output(f, rq->times[i], x, r->value + (size_t)i * (size_t)r->columns);
        else
            memcpy(r->value + (size_t)i * (size_t)f->n, x, (size_t)f->n * sizeof *x);
    }
}

/* Events with the columns there. */
static void keep_events(struct flow *f, const struct traj_request *rq, const struct ode_result *o, struct traj_result *r)
{
    size_t columns = (size_t)r->columns;
    r->happened = o->happened;
    r->happening = sga_malloc((size_t)(o->happened + 1) * sizeof *r->happening);
    r->happened_value = sga_malloc(((size_t)o->happened + 1) * (columns + 1) * sizeof *r->happened_value);
    for (int i = 0; i < o->happened; i++) {
        const struct ode_happening *h = o->happening + i;
        const double *x = o->happened_x + (size_t)i * (size_t)f->n;
        r->happening[i] = (struct traj_happening){ .event = h->event, .direction = h->crossing, .t = h->t, .error = h->error };
        if (rq->outputs)
            flow_output(f, h->t, x, r->happened_value + (size_t)i * columns);
        else
            memcpy(r->happened_value + (size_t)i * columns, x, columns * sizeof *x);
    }
    int last = o->happened - 1;
    while (o->end.reason == ODE_EVENT && last > 0 && !rq->event[o->happening[last].event].stop)
        last--;                /* others at once with it */
    r->ended_event = o->end.reason == ODE_EVENT ? o->happening[last].event : -1;
}

/* Columns that no tighter solution was looked for may have larger errors. */
static void look_beside(const struct flow *f, const struct traj_request *rq, const struct ode_result *o, struct traj_result *r)
{
    for (int i = 0; i < o->count * r->columns && rq->beside && o->column_error && !r->shortfall; i++) {
        int j = i % r->columns;
        double unit = f->sizes->any ? f->sizes->column[j] : 1;
        r->beside = rq->beside[j] && !(o->column_error[i] <= sga_allowed((struct sga_tolerance){ rq->rtol, rq->atol }, unit, r->value[i]));
        if (r->beside)
            r->shortfall = "the value of a root near 0 is known to fewer digits than its argument";
    }
}

static bool integrate(struct flow *f, const struct traj_request *rq, struct traj_result *r,
                      struct sga_error *err)
{
    struct ode_problem problem = flow_problem(f, rq);
    struct ode_start start = { .t = rq->start, .x = r->initial, .count = rq->samples, .times = rq->times };
    struct ode_options options = ode_options_default();
    struct ode_result o;
    options.method = rq->method;
    options.rtol = rq->rtol;
    options.atol = rq->atol;
    options.estimate_global_error = options.refine = !rq->single;
    struct traj_request timed;
    struct sga_budget until;
    options.keep_rows = rows_are_kept(rq);
    options.budget = options.keep_rows ? rows_request(rq, rq->rows_until, &timed, &until)->budget : rq->budget;
    options.output_beside = rq->beside;
    double begin = sga_cpu();
    if (!flow_solve(f, rq, &problem, &start, &options, &o, err))
        return false;
    r->seconds = sga_cpu() - begin;
    drop_at_end(rq, &o);
    keep(f, rq, &o, r);
    keep_events(f, rq, &o, r);
    if (!traj_drift(f, rq, o.samples, o.count, r, err)) {
        ode_result_free(&o);
        return false;
    }
    r->method = o.method;
    r->arithmetic = "double";
    r->residual = o.max_residual;
    r->error_estimate = o.max_error;
    r->shortfall = o.shortfall;
    r->error = o.error ? memcpy(sga_malloc((size_t)(o.count + 1) * sizeof *r->error), o.error,
                                (size_t)o.count * sizeof *r->error) : NULL;
    look_beside(f, rq, &o, r);
    if (o.error)
        r->column_error = traj_column_errors(o.column_error, o.count, r->columns);
    r->ended = o.end.reason != ODE_NONE;
    r->ended_t = o.end.t;
    r->ended_reason = ode_reason_text(o.end.reason);
    snprintf(r->ended_detail, sizeof r->ended_detail, "%s", o.end.detail);
    traj_explain_end(f, rq, o.end.reason, r);
    r->steps = o.stats.steps + o.second.steps;
    r->rejected = o.stats.refused + o.second.refused;
    r->evaluations = o.stats.evaluations + o.second.evaluations;
    bool ok = true;
    if (o.end.reason == ODE_TIME_LIMIT || o.end.reason == ODE_CANCELLED)
        ok = sga_budget_ok(rq->budget, err);
    r->out_of_time = options.keep_rows && (o.end.reason == ODE_TIME_LIMIT || sga_now() >= rq->rows_until);
    ok = ok && (o.end.reason != ODE_TIME_LIMIT || rows_beyond_start(rq, r->rows, err));
    ode_result_free(&o);
    return ok;
}

/* Down to this double arithmetic may do; what it takes in double-double, at most, where it was not asked
 * for: steps times length of the field's tape, and all that implicit steps do. */
static const double DOUBLE_REACHES = 1e-13;
static const double MOST_LENGTH = 2e6, MOST_WORK = 1e9;
static const long MOST_STEPS = 300000;
/* Of the whole way: a motion that comes so much further with other pivots goes on. */
static const double FURTHER = 1e-6;

/* The motion in double, on which events are found before they are located in double-double. Not too tight, since what
 * comes near to 0 is found as a touch then, and looked at again. Both directions are found, and nothing
 * stops: a touch may turn out to be two passages, or none. */
static const double GUIDE_RTOL = 1e-9;

static bool find_events(struct flow *f, const struct traj_request *rq, const double *start, struct traj_result *guide, struct sga_error *err)
{
    struct traj_request q = *rq;
    size_t n = (size_t)f->n, events = (size_t)rq->events;
    struct traj_event *event = memcpy(sga_malloc(events * sizeof *event), rq->event, events * sizeof *event);
    struct ode_event *asked = memcpy(sga_malloc(events * sizeof *asked), f->spec, events * sizeof *asked);
    for (size_t i = 0; i < events; i++) {
        event[i].direction = 0;
        event[i].stop = false;
        f->spec[i] = (struct ode_event){ 0, false };
    }
    q.event = event;
    q.arithmetic = TRAJ_DOUBLE;
    q.rtol = fmax(rq->rtol, GUIDE_RTOL);
    q.atol = fmax(rq->atol, GUIDE_RTOL);
    q.integrals = 0;
    q.rows_until = rows_are_kept(rq) ? rows_first_until(rq->rows_until) : 0;
    q.single = false;
    *guide = (struct traj_result){ .initial = memcpy(sga_malloc((n + 1) * sizeof *start), start, n * sizeof *start) };
    bool ok = integrate(f, &q, guide, err);
    memcpy(f->spec, asked, events * sizeof *asked);
    free(asked);
    free(event);
    return ok;
}

static bool by_time(const struct traj_result *r)
{
    return r->ended && strcmp(r->ended_reason, ode_reason_text(ODE_TIME_LIMIT)) == 0;
}

/* Nothing is known of events beyond the end of the motion in double. */
static bool guided(const struct traj_result *guide, const struct traj_request *rq, const struct traj_result *r, struct sga_error *err)
{
    double last = rq->times[rq->samples - 1], way = last - rq->start, end = r->ended ? r->ended_t : last;
    double beyond = way < 0 ? guide->ended_t - end : end - guide->ended_t;
    if (!guide->ended || beyond <= (guide->ended_event < 0 ? 1e-3 : 1e-6) * fabs(way))
        return true;
    return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/events", "what happens is found in double first, where the motion ends at %.10g (%s); "
                       "ask for an earlier stop, or leave trajectory.events out", guide->ended_t, guide->ended_reason);
}

/* The same, in longer numbers: a sample at the very edge of what must have values may lie beyond it. */
static void drop_at_edge(const struct traj_request *rq, enum ode_reason reason, struct traj_result *r)
{
    double near = rq->rtol * fmax(fabs(r->ended_t), fabs(r->ended_t - rq->start));
    size_t cols = (size_t)r->columns;
    while (rq->valueds && reason == ODE_LEFT_DOMAIN && r->rows > 1 && fabs(r->t[r->rows - 1] - r->ended_t) <= near) {
        r->rows--;
        for (size_t j = 0; r->digits && j < cols; j++)
            free(r->digits[(size_t)r->rows * cols + j]);
    }
}

static bool precise(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                    struct precise_limits limits, struct traj_result *r, struct sga_error *err)
{
    enum ode_reason reason;
    struct traj_result guide = { 0 };
    struct traj_request part = *rq;
    bool ok = !rq->events || find_events(f, rq, r->initial, &guide, err), late = by_time(&guide);
    if (late)       /* as far as events are known */
        part.samples = guide.rows;
    ok = ok && precise_run(f, sys, sol, &part, rq->events ? &guide : NULL, limits, &reason, r, err);
    if (ok)
        drop_at_edge(rq, reason, r);
    if (ok)
        traj_explain_end(f, rq, reason, r);
    if (ok && late && !r->ended) {
        r->ended = true;
        r->ended_t = guide.ended_t;
        r->ended_reason = guide.ended_reason;
        memcpy(r->ended_detail, guide.ended_detail, sizeof r->ended_detail);
    }
    ok = ok && (!rq->events || guided(&guide, rq, r, err));
    traj_result_clear(&guide);
    return ok;
}

/* In double-double where that was not asked for: only if it can be, and is not long. r->initial and
 * what r says of double (steps, 0 at first) are looked at. False: there is nothing in *fine. */
static bool try_precise(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                        const struct traj_result *r, struct traj_result *fine)
{
    const char *why;
    struct sga_error ignored = { 0 };
    double steps = fmin((double)MOST_STEPS, MOST_LENGTH / (50 + num_tape_length(f->field.direct)));
    *fine = (struct traj_result){ .moved = r->moved };
    if (rq->events || !precise_possible(f, rq, &why) || !rq->exact_time || (double)r->steps > 4 * steps)
        return false;
    fine->initial = memcpy(sga_malloc((size_t)f->n * sizeof *fine->initial), r->initial, (size_t)f->n * sizeof *fine->initial);
    if (precise(f, sys, sol, rq, (struct precise_limits){ (long)steps, MOST_WORK }, fine, &ignored))
        return true;
    traj_result_clear(fine);
    return false;
}

/* Double alone no longer tells points of the set from others (long chains of constraints amplify its roundings). */
static bool constraints_lost(const struct traj_result *r)
{
    return r->ended && strcmp(r->ended_reason, "constraint_lost") == 0;
}

static bool lost_by_rounding(const struct traj_result *r, const struct traj_result *fine)
{
    return constraints_lost(r) && !fine->ended;
}

/* Double arithmetic, and what double-double has beside it: the samples are those of the longer numbers where
 * there are as many; of endings that differ, that of double, which has more ways to go on. */
static void choose(struct traj_result *r, struct traj_result *fine)
{
    struct traj_result other = *r;
    if (lost_by_rounding(r, fine)) {
        *r = *fine;
        traj_result_clear(&other);
        return;
    }
    if (fine->rows < r->rows) {
        traj_result_clear(fine);
        return;
    }
    *r = *fine;
    if (constraints_lost(&other) && fine->ended) {
        traj_result_clear(&other);
        return;
    }
    if (other.ended != fine->ended || (other.ended && strcmp(other.ended_reason, fine->ended_reason) != 0)) {
        r->ended = other.ended;
        r->ended_t = other.ended_t;
        r->ended_reason = other.ended_reason;
        memcpy(r->ended_detail, other.ended_detail, sizeof r->ended_detail);
    }
    traj_result_clear(&other);
}

/* The cheapest arithmetic that reaches the tolerances. */
static bool solve_cheapest(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                           struct traj_result *r, struct sga_error *err)
{
    struct traj_result fine;
    bool needed = rq->rtol < DOUBLE_REACHES && rq->atol < DOUBLE_REACHES, there = needed && try_precise(f, sys, sol, rq, r, &fine);
    if (there && (!fine.ended || fine.out_of_time)) {
        traj_result_clear(r);
        *r = fine;
        return true;
    }
    if (!integrate(f, rq, r, err)) {
        if (there)
            traj_result_clear(&fine);
        return false;
    }
    if (there) {
        choose(r, &fine);
    } else if (!needed && !r->out_of_time && ((r->shortfall && !r->beside) || constraints_lost(r)) && try_precise(f, sys, sol, rq, r, &fine)) {
        /* rounding in double: perhaps longer numbers are enough */
        if (fine.shortfall && !lost_by_rounding(r, &fine))
            traj_result_clear(&fine);
        else
            choose(r, &fine);
    }
    return true;
}

static bool solve(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                  struct traj_result *r, struct sga_error *err)
{
    const char *why;
    if (rq->arithmetic == TRAJ_DOUBLE_DOUBLE && !precise_possible(f, rq, &why))
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/accuracy/arithmetic", "%s", why);
    if (rq->arithmetic == TRAJ_DOUBLE_DOUBLE)
        return precise(f, sys, sol, rq, (struct precise_limits){ MOST_STEPS, INFINITY }, r, err);
    return rq->arithmetic == TRAJ_AUTO ? solve_cheapest(f, sys, sol, rq, r, err) : integrate(f, rq, r, err);
}

/* The changes of the motion that was made last. */
static void keep_charts(struct flow *f, struct traj_result *r)
{
    const struct charts *q = f->charts;
    r->chart = sga_calloc((size_t)q->changes + 1, sizeof *r->chart);
    for (r->charts = 0; r->charts < q->changes; r->charts++)
        r->chart[r->charts] = (struct traj_chart){ q->change[r->charts].t, charts_pivot(f, q->change + r->charts) };
}

/* It ended where other pivots may go on. */
static bool ended_by_pivots(const struct traj_result *r)
{
    static const char *const reason[] = { "stratum", "constraint_lost", "left_domain", "blow_up", "not_smooth", "singular", "step_limit" };
    bool may = false;
    for (size_t k = 0; k < sizeof reason / sizeof *reason && r->ended && r->ended_event < 0; k++)
        may |= strcmp(r->ended_reason, reason[k]) == 0;
    return may;
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
    bool ok = field_slope_init(&f->field, err);
    if (ok)
        charts_init(f, sol, rq);
    for (;;) {
        struct sga_error failed = { 0 };
        ok = ok && solve(f, sys, sol, rq, r, had ? &failed : err);
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
    if (!f->field.whole || f->n > SGA_MOST_ROWS_ASKED || !ended_by_pivots(r) || !field_as_reduced(&f->field, rq->start, r->initial, &ignored))
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

static bool run_as_is(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                      struct traj_result *r, struct sga_error *err)
{
    struct flow f;
    double begin;
    *r = (struct traj_result){ 0 };
    bool ok = flow_init(&f, sys, sol, rq, err);
    if (ok) {
        r->initial = sga_calloc((size_t)f.n + 1, sizeof *r->initial);
        ok = flow_start(&f, sys, sol, rq, r->initial, &r->moved, err) && flow_given(&f, rq, r->initial, err)
             && field_begin(&f.field, rq->start, r->initial, err);
        begin = sga_cpu();
        if (ok && rq->arithmetic == TRAJ_BALL) {
            ok = enclosed_run(&f, sys, sol, rq, r, err);
            r->seconds = sga_cpu() - begin;
        } else if (ok) {
            ok = solve_in_charts(&f, sys, sol, rq, r, err) && (solve_as_reduced(&f, sys, sol, rq, r) || sga_budget_ok(rq->budget, err));
        }
    }
    if (ok) {
        if (f.sizes->any)
            r->unit = memcpy(sga_malloc(((size_t)r->columns + 1) * sizeof *r->unit), f.sizes->column, (size_t)r->columns * sizeof *r->unit);
        r->inputs_examined = f.inputs->complete || rq->arithmetic == TRAJ_BALL;
        r->gauge = flow_gauge(&f, rq);
        r->gauge_numeric = f.field.choice.why;
    } else if (!err->stage[0]) {
        memcpy(err->stage, "trajectory", 11);
    }
    flow_clear(&f);
    if (!ok)
        traj_result_clear(r);
    return ok;
}

/* The start may lie where a pivot of the reduction is 0 and the rank stays: then that of other pivots is tried. */
static bool run_from_start(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                           struct traj_result *r, struct sga_error *err)
{
    struct sga_error first = { 0 }, ignored = { 0 };
    struct sga_solution own;
    struct points_oracle oracle;
    if (run_as_is(sys, sol, rq, r, &first))
        return true;
    bool may = first.code == SGA_E_INITIAL || first.code == SGA_E_NO_MOTION, ok = false;
    if (may && charts_solve_at_start(sys, sol, rq, &own, &oracle)) {
        ok = run_as_is(sys, &own, rq, r, &ignored);
        sga_solution_clear(&own);
        points_oracle_clear(&oracle);
    }
    if (!ok)
        *err = first;
    return ok;
}

/* It ended at a singular position: the motion in pieces may pass it. */
static void go_through(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r)
{
    struct traj_result through;
    struct sga_error ignored = { 0 };
    bool may = r->stratum && !rq->ends_there && !rq->single && !rq->turns && rq->arithmetic != TRAJ_BALL;
    if (!may || !jumps_run(sys, sol, rq, &through, &ignored))
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
    if (!defined_any(sol, rq))
        return run_from_start(sys, sol, rq, r, err);
    *r = (struct traj_result){ 0 };
    defined_init(&d, sys, sol, rq);
    bool ok = defined_start(&d, err) && run_as_is(&d.system, &d.solution, &d.request, r, err);
    if (ok) {
        r->initial = defined_lift(&d, r->initial);
        r->moved = defined_moved(&d, r->initial, r->moved);
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
    if (jumps_any(rq))
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
