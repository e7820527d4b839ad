/* A trajectory in double-double from request to samples: several solutions, the error of the
 * last from its difference to the one before, as lib/ode/global.c, and its digits. */
#include "precise.h"
#include "precise_turn.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "charts.h"
#include "collocation.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "gauge_choice.h"
#include "knots.h"
#include "manifold.h"
#include "mem.h"
#include "rows_kept.h"
#include "sizes.h"
#include "system.h"
#include "table_balls.h"
#include "tape.h"
#include "tolerance.h"
#include "trajectory.h"

#define LOOSER 10.0
#define LOOSEST 1e4
#define ALLOWANCE 1.5
#define SURE 100.0
#define TIGHTEST_RTOL 1e-31
#define MOST_SOLUTIONS 6
#define NEIGHBOUR 30.0
#define FEWEST_DIGITS 3
#define MOST_DIGITS 32

struct outcome {
    struct precise_path path;
    int columns;
    num_dd *value;             /* rows x columns */
    double *column_error, *error, worst;
    double end_error;          /* of path.t; 0: not known */
};

bool precise_possible(const struct flow *f, const struct traj_request *rq, const char **why)
{
    *why = f->field->choice->why
               ? "the gauge choice is solved from the equations at every evaluation, in double arithmetic only (trajectory.gauge_numeric "
                 "says why); fix the gauge by conditions or other rates, or use \"double\""
           : !f->field->fast || !f->field->plain
               ? "the field is solved from the equations at every evaluation, as its expressions lose digits at the start; use \"double\""
           : rq->method && strcmp(rq->method, "auto") != 0 && strcmp(rq->method, "taylor") != 0 && strcmp(rq->method, "radau") != 0
               ? "double-double arithmetic integrates by Taylor series and by Radau's formulas; use the method \"taylor\", \"radau\" or \"auto\""
           : rq->method && strcmp(rq->method, "radau") == 0 && !precise_radau_possible(f->field)
               ? "the Jacobian is too large and too full for implicit steps in double-double arithmetic; use the method \"taylor\" or \"auto\", or \"double\""
               : NULL;
    return !*why;
}

static void columns(struct precise *p, num_dd t, const num_dd *x, num_dd *out)
{
    if (!p->output) {
        memcpy(out, x, (size_t)p->n * sizeof *x);
        return;
    }
    for (int j = 0; j < p->n; j++)
        num_jet2_input(p->output, j)[0] = x[j];
    num_jet2_input(p->output, p->n)[0] = t;
    num_jet2_next(p->output, 0);
    for (int k = 0; k < p->rq->outputs; k++)
        out[k] = num_jet2_root(p->output, k)[0];
}

static void solve(struct precise *p, double rtol, double atol, bool beside, struct outcome *o)
{
    *o = (struct outcome){ .columns = p->rq->outputs ? p->rq->outputs : p->n };
    precise_march(p, rtol, atol, beside, &o->path);
    p->solution++;
    o->value = sga_calloc((size_t)o->path.count * (size_t)o->columns + 1, sizeof *o->value);
    for (int k = 0; k < o->path.count; k++)
        columns(p, p->time[k], o->path.sample + (size_t)k * (size_t)p->n, o->value + (size_t)k * (size_t)o->columns);
}

static void clear(struct outcome *o)
{
    precise_path_clear(&o->path);
    free(o->value);
    free(o->column_error);
    free(o->error);
    *o = (struct outcome){ 0 };
}

/* The difference of the two values; a difference cannot show a few roundings of their size. */
static double raw_error(const struct outcome *a, const struct outcome *b, double factor, int k, int j)
{
    size_t at = (size_t)k * (size_t)a->columns + (size_t)j;
    if (k >= b->path.count)
        return INFINITY;
    double e = factor * fabs(num_dd_sub(a->value[at], b->value[at]).hi) + 16 * NUM_DD_EPSILON * fabs(a->value[at].hi);
    return isnan(e) ? INFINITY : e;
}

/* a's errors by its difference to b. Differences can pass through 0: see lib/ode/global.c. */
static void set_errors(const struct precise *p, struct outcome *a, const struct outcome *b, double factor, double rtol)
{
    int rows = a->path.count, cols = a->columns;
    free(a->column_error);
    free(a->error);
    a->column_error = sga_calloc((size_t)rows * (size_t)cols + 1, sizeof *a->column_error);
    a->error = sga_calloc((size_t)rows + 1, sizeof *a->error);
    double *row = sga_calloc((size_t)rows + 1, sizeof *row);
    const struct sga_tolerance asked = { p->rq->rtol, p->rq->atol };
    a->worst = rows > b->path.count ? INFINITY : 0;
    for (int k = 0; k < rows; k++)
        for (int j = 0; j < cols; j++) {
            double e = a->column_error[k * cols + j] = raw_error(a, b, factor, k, j);
            row[k] = fmax(row[k], e);
            a->worst = fmax(a->worst, sga_error_ratio(e, asked, p->flow->sizes->column[j], a->value[k * cols + j].hi));
        }
    for (int k = 0; k < rows; k++) {
        double before = k > 0 ? row[k - 1] : 0, after = k + 1 < rows && isfinite(row[k + 1]) ? row[k + 1] : 0;
        a->error[k] = fmax(row[k], fmin(fmax(before, after), NEIGHBOUR * row[k]));
        for (int j = 0; j < cols && row[k] > 0; j++)
            a->column_error[k * cols + j] *= a->error[k] / row[k];
    }
    free(row);
    a->worst = fmax(a->worst, precise_event_errors(p, &a->path, &b->path, factor));
    bool placed = ode_reason_placed(a->path.reason) && ode_reason_placed(b->path.reason);
    a->end_error = placed ? ode_end_error(fabs(a->path.t - b->path.t), rtol, a->path.t - p->rq->start) + fmax(a->path.left, b->path.left) + 2 * DBL_EPSILON * fmax(fabs(a->path.t), fabs(a->path.t - p->rq->start)) : 0;
}

/* One solution is all there is. */
static void errors_unknown(struct outcome *o)
{
    o->error = sga_malloc(((size_t)o->path.count + 1) * sizeof *o->error);
    o->column_error = sga_malloc(((size_t)o->path.count * (size_t)o->columns + 1) * sizeof *o->column_error);
    for (int k = 0; k < o->path.count * o->columns; k++)
        o->column_error[k] = o->error[k / o->columns] = INFINITY;
}

static bool out_of_budget(const struct precise_path *q)
{
    return q->reason == ODE_TIME_LIMIT || q->reason == ODE_CANCELLED;
}

static void add_counts(const struct precise_path *q, struct traj_result *r)
{
    r->steps += q->steps;
    r->rejected += q->refused;
    r->evaluations += q->evaluations;
}

/* In what the first of two solutions may take, where rows are to be kept. */
static void solve_first(struct precise *p, double rtol, double atol, struct outcome *o)
{
    const struct traj_request *all = p->rq;
    struct traj_request own;
    struct sga_budget part;
    if (rows_are_kept(all))
        p->rq = rows_request(all, rows_first_until(all->rows_until), &own, &part);
    solve(p, rtol, atol, true, o);
    p->rq = all;
}

/* The time ended: it ends at its last sample, whose time it says, and so does the other. */
static void end_at_rows(const struct precise *p, struct outcome *o, struct outcome *other, const char *detail)
{
    double direction = p->rq->times[p->rq->samples - 1] < p->rq->start ? -1 : 1, t = o->path.count ? p->rq->times[o->path.count - 1] : p->rq->start;
    precise_drop_events(&o->path, t, direction);
    precise_drop_events(&other->path, t, direction);
    o->path.reason = ODE_TIME_LIMIT;
    o->path.t = t;
    memmove(o->path.detail, detail, sizeof o->path.detail);
}

/* The time for the first solution ended: its samples are solved once more, tighter. As many as that reaches are kept, with their errors. */
static const char *keep_rows(struct precise *p, double rtol, double atol, struct outcome *o, struct traj_result *r)
{
    const struct traj_request *all = p->rq;
    struct traj_request part = *all;
    struct outcome tight;
    part.samples = o->path.count;
    p->rq = &part;
    add_counts(&o->path, r);
    solve(p, rtol / LOOSER, atol / LOOSER, false, &tight);
    p->rq = all;
    if (tight.path.reason == ODE_NONE || tight.path.reason == ODE_TIME_LIMIT)
        end_at_rows(p, &tight, o, o->path.detail);
    set_errors(p, &tight, o, ALLOWANCE, rtol / LOOSER);
    clear(o);
    *o = tight;
    return o->worst <= 1 ? NULL : rows_shortfall;
}

/* The time ended in a solution after the first. True: the one before stays, which has its errors; otherwise the rows of this one are what is known. */
static bool stays(struct precise *p, const struct outcome *o, struct outcome *next)
{
    return rows_are_kept(p->rq) && next->path.reason == ODE_TIME_LIMIT && o->error && next->path.count < o->path.count;
}

/* Solves until the estimate is within the tolerances asked for. Returns why it is not, or NULL. */
static const char *refine(struct precise *p, struct outcome *o, struct traj_result *r)
{
    double rtol = fmax(p->rq->rtol, LOOSER * TIGHTEST_RTOL), atol = p->rq->atol, ratio = LOOSER, apart = 0;
    if (p->rq->single) {
        solve(p, rtol, atol, false, o);
        return NULL;
    }
    solve_first(p, rtol, atol, o);
    if (rows_are_kept(p->rq) && o->path.reason == ODE_TIME_LIMIT && o->path.count)
        return keep_rows(p, rtol, atol, o, r);
    for (int solutions = 1; solutions < MOST_SOLUTIONS && !out_of_budget(&o->path); solutions++) {
        struct outcome next;
        double before = o->worst, apart_before = apart;
        assert(ratio >= 2);       /* solutions nearer to each other say nothing of their errors */
        rtol /= ratio;
        atol /= ratio;
        add_counts(&o->path, r);
        solve(p, rtol, atol, false, &next);
        if (stays(p, o, &next)) {
            add_counts(&next.path, r);
            o->path.steps = o->path.refused = o->path.evaluations = 0;       /* added already */
            clear(&next);
            return rows_shortfall;
        }
        if (rows_are_kept(p->rq) && next.path.reason == ODE_TIME_LIMIT)
            end_at_rows(p, &next, o, next.path.detail);
        set_errors(p, &next, o, ALLOWANCE, rtol);
        apart = next.worst;         /* what falls where tolerances still count: the estimate may have another factor than the one before */
        if (ratio > LOOSER && next.worst < 0.3 * before)
            set_errors(p, &next, o, fmin(ALLOWANCE, SURE / ratio), rtol);
        clear(o);
        *o = next;
        if (o->worst <= 1)
            return NULL;
        ratio = fmin(fmin(LOOSEST, fmax(LOOSER, 0.5 * o->worst)), rtol / TIGHTEST_RTOL);
        if (isinf(o->worst))
            ratio = fmin(LOOSER, ratio);
        if (ratio < 2 || (solutions > 2 && !(apart < 0.9 * apart_before)))
            break;
    }
    if (!o->error)
        errors_unknown(o);
    return out_of_budget(&o->path) ? rows_shortfall
           : isinf(o->worst) ? "the solutions that were compared do not end at the same time, or not with the same events; errors beyond are not known"
                           : "rounding in double-double arithmetic, as the motion amplifies it, exceeds the tolerance";
}

char *precise_digits(num_dd v, double error)
{
    double size = fabs(v.hi);
    int digits = size > 0 && error > 0 && isfinite(error) ? (int)floor(log10(size / error)) + 2 : isfinite(error) ? MOST_DIGITS : 17;
    return num_dd_text(v, digits < FEWEST_DIGITS ? FEWEST_DIGITS : digits > MOST_DIGITS ? MOST_DIGITS : digits);
}

static void keep(const struct precise *p, const struct outcome *o, struct traj_result *r)
{
    int rows = o->path.count, cols = o->columns;
    size_t all = (size_t)rows * (size_t)cols;
    r->rows = rows;
    r->columns = cols;
    r->t = memcpy(sga_malloc(((size_t)rows + 1) * sizeof *r->t), p->rq->times, (size_t)rows * sizeof *r->t);
    r->value = sga_malloc((all + 1) * sizeof *r->value);
    r->digits = sga_calloc(all + 1, sizeof *r->digits);
    if (o->error) {
        r->error = memcpy(sga_malloc(((size_t)rows + 1) * sizeof *r->error), o->error, (size_t)rows * sizeof *r->error);
        r->column_error = traj_column_errors(o->column_error, rows, r->columns);
    }
    for (size_t i = 0; i < all; i++) {
        r->value[i] = o->value[i].hi;
        r->digits[i] = precise_digits(o->value[i], o->error ? o->column_error[i] : 0);
    }
    r->error_estimate = o->error ? 0 : -1;
    for (int k = 0; k < rows && o->error; k++)
        r->error_estimate = fmax(r->error_estimate, r->error[k]);
    r->ended_event = -1;
    r->method = o->path.method;
    r->arithmetic = "double-double";
    r->residual = o->path.residual;
    r->ended = o->path.reason != ODE_NONE;
    r->ended_t = o->path.t;
    r->ended_error = o->worst <= 1 ? o->end_error : 0;       /* as in lib/ode/global.c */
    r->ended_reason = ode_reason_text(o->path.reason);
    snprintf(r->ended_detail, sizeof r->ended_detail, "%s", o->path.detail);
    add_counts(&o->path, r);
}

/* By how much each column changes in the time by which an event may be wrong: other - value, from the velocity there. */
static void drift_of(struct precise *p, const struct precise_event *e, const num_dd *value, num_dd *other, size_t cols)
{
    int n = p->n;
    num_dd *x = sga_malloc(((size_t)n + 1) * sizeof *x);
    for (int j = 0; j <= n; j++)
        num_jet2_input(p->velocity, j)[0] = j < n ? e->x[j] : e->t;
    bool ok = num_jet2_next(p->velocity, 0);
    for (int j = 0; j < n; j++)
        x[j] = num_dd_add(e->x[j], num_dd_mul_d(num_jet2_root(p->velocity, j)[0], e->error));
    columns(p, num_dd_add_d(e->t, e->error), x, other);
    for (size_t c = 0; c < cols; c++)
        other[c] = ok ? num_dd_sub(other[c], value[c]) : num_dd_of(INFINITY);
    free(x);
}

/* The events with their columns. */
static void keep_events(struct precise *p, const struct outcome *o, struct traj_result *r)
{
    size_t cols = (size_t)r->columns, count = (size_t)o->path.events;
    num_dd *value = sga_malloc(2 * (cols + 1) * sizeof *value), *other = value + cols + 1;
    r->happened = o->path.events;
    r->happening = sga_malloc((count + 1) * sizeof *r->happening);
    r->happened_value = sga_malloc((count + 1) * (cols + 1) * sizeof *r->happened_value);
    r->happened_digits = sga_calloc((count + 1) * (cols + 1), sizeof *r->happened_digits);
    for (size_t i = 0; i < count; i++) {
        const struct precise_event *e = o->path.event + i;
        char **digits = r->happened_digits + i * (cols + 1);
        r->happening[i] = (struct traj_happening){ .event = e->event, .direction = e->direction, .t = e->t.hi, .error = e->error };
        bool all = p->rq->single || p->rq->event_side;      /* a piece: the next one goes on from there */
        double error = all ? 0 : e->error, beside = 10 * (error + r->error_estimate);
        digits[0] = precise_digits(e->t, error);
        columns(p, e->t, e->x, value);
        drift_of(p, e, value, other, cols);
        for (size_t j = 0; j < cols; j++) {
            r->happened_value[i * cols + j] = value[j].hi;
            digits[j + 1] = precise_digits(value[j], all ? 0 : beside + 2 * fabs(other[j].hi));
        }
    }
    field_keep_held(p->flow->field, o->path.held, r);
    assert(o->path.reason != ODE_EVENT || o->path.events > 0);
    int last = o->path.events - 1;
    while (o->path.reason == ODE_EVENT && last > 0 && !p->rq->event[o->path.event[last].event].stop)
        last--;                /* others at once with it */
    if (o->path.reason == ODE_EVENT)
        r->ended_event = o->path.event[last].event;
    free(value);
}

static void precise_clear(struct precise *p)
{
    charts_return(p->flow);
    precise_follow_chart(p);
    precise_charts_clear(p);
    if (p->field != p->flow->field->plain)
        num_tape_free(p->field);
    num_jet2_free(p->constraint);
    num_jet2_free(p->output);
    num_jet2_free(p->series);
    num_jet2_free(p->values);
    num_jet2_free(p->event);
    num_jet2_free(p->velocity);
    num_radau_free(p->formula);
    precise_turn_free(p->turn);
    if (p->knots)
        knots_clear(p->knots);
    free(p->knots);
    free(p->knot);
    free(p->time);
    free(p->x);
}

/* The knots of the tables, and tables in double-double. */
static bool with_tables(struct precise *p, struct sga_error *err)
{
    p->knots = sga_calloc(1, sizeof *p->knots);
    if (!knots_init(p->knots, p->sys, p->rq, err))
        return false;
    for (int k = 0; k < p->knots->tables; k++)
        num_table_fine(p->knots->table[k]);
    p->knot = sga_malloc(((size_t)p->knots->count + 1) * sizeof *p->knot);
    for (int k = 0; k < p->knots->count; k++)
        p->knot[k] = num_dd_of_fmpq(p->knots->knot + k);
    return true;
}

bool precise_place(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, num_dd *x, struct sga_error *err)
{
    struct flow f;
    double moved;
    struct precise p = { .flow = &f, .sys = sys, .sol = sol, .rq = rq, .n = sys->variables };
    SGA_FREED double *near = sga_calloc((size_t)sys->variables + 1, sizeof *near);
    bool ok = flow_init(&f, sys, sol, rq, err) && flow_start(&f, sys, sol, rq, near, &moved, err);
    if (ok) {
        p.time = sga_calloc((size_t)rq->samples + 1, sizeof *p.time);
        p.x = sga_calloc((size_t)p.n + 1, sizeof *p.x);
        p.constraint = num_jet2_new(f.manifold->tape, 1);
        p.field = f.field->plain;
        ok = with_tables(&p, err) && precise_start(&p, near, err);
        memcpy(x, p.x, (size_t)p.n * sizeof *x);
        precise_clear(&p);
    }
    flow_clear(&f);
    return ok;
}

bool precise_run(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                 struct precise_limits limits, enum ode_reason *reason, struct traj_result *r, struct sga_error *err)
{
    struct traj_request timed;
    struct sga_budget until;
    struct precise p = { .flow = f, .sys = sys, .sol = sol, .rq = rows_are_kept(rq) ? rows_request(rq, rq->rows_until, &timed, &until) : rq, .n = f->n, .limits = limits };
    struct outcome o = { 0 };
    charts_return(f);
    p.time = sga_calloc((size_t)rq->samples + 1, sizeof *p.time);
    p.x = sga_calloc((size_t)f->n + 1, sizeof *p.x);
    p.constraint = num_jet2_new(f->manifold->tape, 1);
    p.output = f->output ? num_jet2_new(f->output, 0) : NULL;
    if (rq->events) {
        p.event = num_jet2_new(f->event, 1);
        p.velocity = num_jet2_new(f->field->plain, 0);
    }
    p.field = precise_field(&p);
    p.turn = precise_turn_new(&p, err);
    bool ok = err->code == SGA_E_OK && with_tables(&p, err) && (p.field || sga_fail(err, SGA_E_INTERNAL, "the field has no program in double-double")) && precise_start(&p, r->initial, err);
    if (ok) {
        r->steps = r->rejected = r->evaluations = 0;
        double begin = sga_cpu();
        r->shortfall = refine(&p, &o, r);
        r->seconds = sga_cpu() - begin;
        keep(&p, &o, r);
        for (int j = 0; j < f->n; j++)
            r->initial[j] = p.x[j].hi;
        if (rq->events)
            keep_events(&p, &o, r);
        r->out_of_time = rows_are_kept(rq) && (out_of_budget(&o.path) || sga_now() >= rq->rows_until);
        if (out_of_budget(&o.path) || !rows_may_end(rq, NULL))
            ok = rows_may_end(rq, err) && rows_beyond_start(rq, r->rows, err);
        *reason = o.path.reason;
    }
    clear(&o);
    precise_clear(&p);
    return ok;
}
