/* A motion in double arithmetic: see in_double.h. */
#include "in_double.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "blow_up.h"
#include "budget.h"
#include "endings.h"
#include "field.h"
#include "flow.h"
#include "mem.h"
#include "rows_kept.h"
#include "sizes.h"
#include "tolerance.h"

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
    field_keep_held(f->field, o->held, r);
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

bool in_double_run(struct flow *f, const struct traj_request *rq, struct traj_result *r, struct sga_error *err)
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
    r->ended_error = o.end.error;
    traj_explain_end(f, rq, o.end.reason, r);
    r->steps = o.stats.steps + o.second.steps;
    r->rejected = o.stats.refused + o.second.refused;
    r->evaluations = o.stats.evaluations + o.second.evaluations;
    options.rtol = o.rtol;
    options.atol = o.atol;
    if (r->ended && !rq->single)
        blow_up_confirm(&problem, &start, &options, r);
    bool ok = true;
    if (o.end.reason == ODE_TIME_LIMIT || o.end.reason == ODE_CANCELLED)
        ok = rows_may_end(rq, err);
    r->out_of_time = options.keep_rows && (o.end.reason == ODE_TIME_LIMIT || sga_now() >= rq->rows_until);
    ok = ok && (o.end.reason != ODE_TIME_LIMIT || rows_beyond_start(rq, r->rows, err));
    ode_result_free(&o);
    return ok;
}
