/* A trajectory from request to samples. */
#include "trajectory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "consistent.h"
#include "field.h"
#include "mem.h"
#include "ode.h"
#include "print.h"
#include "sparse.h"

struct flow {
    struct manifold manifold;
    struct field field;
    struct num_tape *output;      /* inputs: variables, time */
    struct num_tape *event;       /* the same */
    struct ode_event *spec;
    double *in;
    int n;
};

static bool rhs(void *ctx, double t, const double *x, double *dx)
{
    struct flow *f = ctx;
    return field_eval(&f->field, t, x, dx);
}

/* The correction is the least one in units of the error allowed: a rounding of a large
 * variable must not be paid for by a small one. */
static bool project(void *ctx, double t, double *x, const double *scale, double *moved, double *residual)
{
    struct flow *f = ctx;
    int n = f->n;
    memcpy(f->in, x, (size_t)n * sizeof *x);
    bool ok = manifold_project(&f->manifold, t, x, scale, NULL, 8, NULL, NULL, NULL);
    double sum = 0;
    for (int j = 0; j < n; j++) {
        double d = (x[j] - f->in[j]) / scale[j];
        sum += d * d;
    }
    *moved = sqrt(sum / n);
    *residual = f->manifold.raw;
    return ok;
}

static bool slope(void *ctx, double t, const double *x, double *value)
{
    struct flow *f = ctx;
    return field_slope(&f->field, t, x, value);
}

/* The columns of a sample. */
static void output(void *ctx, double t, const double *x, double *y)
{
    struct flow *f = ctx;
    memcpy(f->in, x, (size_t)f->n * sizeof *x);
    f->in[f->n] = t;
    num_tape_eval(f->output, f->in, y);
}

static enum ode_reason why(void *ctx)
{
    struct flow *f = ctx;
    return f->field.rank_lost || f->field.contradiction ? ODE_SINGULAR : ODE_LEFT_DOMAIN;
}

static void event(void *ctx, double t, const double *x, double *g)
{
    struct flow *f = ctx;
    memcpy(f->in, x, (size_t)f->n * sizeof *x);
    f->in[f->n] = t;
    num_tape_eval(f->event, f->in, g);
}

static bool event_tape(struct flow *f, const struct sys_system *sys, const struct traj_request *rq, const int *inputs,
                       struct sga_error *err)
{
    expr_id *root = sga_malloc((size_t)rq->events * sizeof *root);
    f->spec = sga_malloc((size_t)rq->events * sizeof *f->spec);
    for (int i = 0; i < rq->events; i++) {
        root[i] = rq->event[i].expression;
        f->spec[i] = (struct ode_event){ rq->event[i].direction, rq->event[i].stop };
    }
    f->event = num_tape_new(sys->store, root, rq->events, inputs, f->n + 1, err);
    free(root);
    return f->event != NULL;
}

static bool flow_init(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol,
                      const struct traj_request *rq, struct sga_error *err)
{
    int n = sys->variables;
    *f = (struct flow){ .n = n };
    if (!manifold_init(&f->manifold, sys, sol, err) || !field_init(&f->field, sys, sol, rq, &f->manifold, err))
        return false;
    f->in = sga_malloc((size_t)(n + 1) * sizeof *f->in);
    if (!rq->outputs && !rq->events)
        return true;
    int *inputs = sga_malloc((size_t)(n + 1) * sizeof *inputs);
    for (int j = 0; j < n; j++)
        inputs[j] = sys->variable[j].symbol;
    inputs[n] = sys->time;
    bool ok = !rq->outputs || (f->output = num_tape_new(sys->store, rq->output, rq->outputs, inputs, n + 1, err));
    ok = ok && (!rq->events || event_tape(f, sys, rq, inputs, err));
    free(inputs);
    return ok;
}

static void flow_clear(struct flow *f)
{
    manifold_clear(&f->manifold);
    field_clear(&f->field);
    num_tape_free(f->output);
    num_tape_free(f->event);
    free(f->spec);
    free(f->in);
}

/* Some point of the set, for a start of last resort: found by a fresh search. */
static double *known_point(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq)
{
    int n = sys->variables;
    int *variable = sga_malloc((size_t)(n + 1) * sizeof *variable);
    expr_id *con = sga_malloc((size_t)(sol->constraints + 1) * sizeof *con);
    for (int j = 0; j < n; j++)
        variable[j] = sys->variable[j].symbol;
    for (int i = 0; i < sol->constraints; i++)
        con[i] = sol->constraint[i].expr;
    struct points_space space = { .st = sys->store, .variable = variable, .variables = n, .time = sys->time,
                                  .constraint = con, .constraints = sol->constraints, .near = rq->initial,
                                  .near_time = rq->start, .budget = rq->budget };
    struct points_point p;
    uint64_t random = 3;
    double *x = NULL;
    int *end = sga_calloc((size_t)sol->generations + 1, sizeof *end), stages = sga_stages(sol, end);
    if (points_find_staged(&space, end, stages, 0, &random, 64, &p) == POINTS_OK)
        x = memcpy(sga_malloc((size_t)n * sizeof *x), p.x, (size_t)n * sizeof *x);
    points_point_clear(&p);
    free(end);
    free(variable);
    free(con);
    return x;
}

/* The consistent start; where the guess leads nowhere, from a point that a search finds. */
static bool start(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol,
                  const struct traj_request *rq, double *x, double *moved, struct sga_error *err)
{
    if (consistent_start(&f->manifold, sys, sol, rq, NULL, x, moved, NULL))
        return true;
    double *elsewhere = known_point(sys, sol, rq);
    bool ok = consistent_start(&f->manifold, sys, sol, rq, elsewhere, x, moved, err);
    free(elsewhere);
    return ok;
}

/* Coordinates of Pf near x: what elimination of the differentials leaves unsolved, values
 * that were not given being solved for first. */
static void free_coordinates(struct flow *f, const struct traj_request *rq, struct traj_initial *r)
{
    int n = f->n, c = f->manifold.c;
    unsigned char *solved = sga_calloc((size_t)n + 1, 1);
    struct points_row *row = sga_calloc((size_t)c + 1, sizeof *row);
    manifold_residual(&f->manifold, rq->start, r->x, NULL, NULL);
    for (int i = 0; i < c; i++) {
        int len = f->manifold.cols[i];
        row[i].len = row[i].cap = len;
        row[i].col = sga_malloc((size_t)(len + 1) * sizeof(int));
        row[i].val = sga_malloc((size_t)(len + 1) * sizeof(double));
        for (int k = 0; k < len; k++) {
            row[i].col[k] = f->manifold.col[i][k];
            row[i].val[k] = f->manifold.step.value[i][k] * (rq->given[row[i].col[k]] ? 1 : 1e3);
        }
    }
    struct points_lu lu;
    points_lu_factor(&lu, row, c, n, 1e-10);
    for (int k = 0; k < lu.rank; k++)
        solved[lu.pivot_col[k]] = 1;
    points_lu_clear(&lu);
    r->free = sga_malloc((size_t)(n + 1) * sizeof *r->free);
    for (int j = 0; j < n; j++)
        if (!solved[j])
            r->free[r->frees++] = j;
    free(solved);
}

bool traj_consistent(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                     struct traj_initial *r, struct sga_error *err)
{
    struct flow f;
    *r = (struct traj_initial){ 0 };
    bool ok = flow_init(&f, sys, sol, rq, err);
    if (ok) {
        int n = f.n, c = f.manifold.c;
        r->x = sga_calloc((size_t)n + 1, sizeof *r->x);
        r->derivative = sga_calloc((size_t)n + 1, sizeof *r->derivative);
        r->residual = sga_calloc((size_t)c + 1, sizeof *r->residual);
        ok = start(&f, sys, sol, rq, r->x, &r->moved, err) && field_begin(&f.field, rq->start, r->x, err) && field_eval(&f.field, rq->start, r->x, r->derivative);
        if (ok) {
            memcpy(f.in, r->x, (size_t)n * sizeof *f.in);
            f.in[n] = rq->start;
            num_tape_eval(f.manifold.tape, f.in, r->residual);
            free_coordinates(&f, rq, r);
        }
    }
    flow_clear(&f);
    if (!ok)
        traj_initial_clear(r);
    return ok;
}

void traj_initial_clear(struct traj_initial *r)
{
    free(r->x);
    free(r->derivative);
    free(r->residual);
    free(r->free);
    *r = (struct traj_initial){ 0 };
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
            output(f, rq->times[i], x, r->value + (size_t)i * (size_t)r->columns);
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
        r->happening[i] = (struct traj_happening){ h->event, h->crossing, h->t, h->error };
        if (rq->outputs)
            output(f, h->t, x, r->happened_value + (size_t)i * columns);
        else
            memcpy(r->happened_value + (size_t)i * columns, x, columns * sizeof *x);
    }
    r->ended_event = o->end.reason == ODE_EVENT ? o->happening[o->happened - 1].event : -1;
}

/* A trajectory that reaches a stratum says what is lost there. */
static void say_stratum(struct flow *f, struct traj_result *r)
{
    struct sga_buf text = { 0 };
    r->ended_reason = f->field.contradiction ? "gauge_contradiction" : "stratum";
    if (f->field.contradiction)
        snprintf(r->ended_detail, sizeof r->ended_detail, "the rates asked for contradict the equations beyond this time");
    else if (f->field.lost_pivot >= 0 && expr_print(f->field.sys->store, f->field.pivot_expr[f->field.lost_pivot], 120, &text))
        snprintf(r->ended_detail, sizeof r->ended_detail, f->field.lost_pivot < f->field.sides
                 ? "the constraints were found on one side of %s = 0 only: beyond it they say something else"
                 : "the rank of the equations drops where %s = 0: the motion is not determined beyond", text.data);
    else
        snprintf(r->ended_detail, sizeof r->ended_detail,
                 "the rank of the equations drops here: the motion is not determined beyond");
    sga_buf_free(&text);
}

/* What grows without bound may be what a stratum leaves undetermined. */
static void look_for_stratum(struct flow *f, const struct traj_request *rq, struct traj_result *r)
{
    struct sga_buf text = { 0 };
    int pivot = field_approaches(&f->field, r->initial, rq->start, r->ended_t);
    if (pivot >= 0 && expr_print(f->field.sys->store, f->field.pivot_expr[pivot], 120, &text)) {
        r->ended_reason = "stratum";
        snprintf(r->ended_detail, sizeof r->ended_detail, "the rank of the equations drops where %s = 0, which the motion tends "
                 "to: it is not determined beyond", text.data);
    }
    sga_buf_free(&text);
}

static bool integrate(struct flow *f, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r,
                      struct sga_error *err)
{
    if (!field_slope_init(&f->field, sol, err))
        return false;
    struct ode_problem problem = { .n = f->n, .ctx = f, .rhs = rhs, .project = f->manifold.c ? project : NULL, .why = why,
                                   .pattern = f->field.pattern, .jacobian = f->field.pattern ? slope : NULL,
                                   .cost = 4.0 * num_tape_length(f->field.direct),
                                   .outputs = rq->outputs, .output = rq->outputs ? output : NULL,
                                   .events = rq->events, .event_spec = f->spec, .event = event };
    struct ode_start start = { .t = rq->start, .x = r->initial, .count = rq->samples, .times = rq->times };
    struct ode_options options = ode_options_default();
    struct ode_result o;
    options.method = rq->method;
    options.rtol = rq->rtol;
    options.atol = rq->atol;
    options.estimate_global_error = options.refine = true;
    options.budget = rq->budget;
    if (!ode_solve(&problem, &start, &options, &o, err))
        return false;
    keep(f, rq, &o, r);
    keep_events(f, rq, &o, r);
    r->method = o.method;
    r->residual = o.max_residual;
    r->error_estimate = o.max_error;
    r->shortfall = o.shortfall;
    r->error = o.error ? memcpy(sga_malloc((size_t)(o.count + 1) * sizeof *r->error), o.error,
                                (size_t)o.count * sizeof *r->error) : NULL;
    r->ended = o.end.reason != ODE_NONE;
    r->ended_t = o.end.t;
    r->ended_reason = ode_reason_text(o.end.reason);
    snprintf(r->ended_detail, sizeof r->ended_detail, "%s", o.end.detail);
    if (o.end.reason == ODE_SINGULAR)
        say_stratum(f, r);
    else if (o.end.reason == ODE_BLOW_UP)
        look_for_stratum(f, rq, r);
    r->steps = o.stats.steps + o.second.steps;
    r->rejected = o.stats.refused + o.second.refused;
    r->evaluations = o.stats.evaluations + o.second.evaluations;
    bool ok = true;
    if (o.end.reason == ODE_TIME_LIMIT || o.end.reason == ODE_CANCELLED)
        ok = sga_budget_ok(rq->budget, err);
    ode_result_free(&o);
    return ok;
}

bool traj_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
              struct traj_result *r, struct sga_error *err)
{
    struct flow f;
    *r = (struct traj_result){ 0 };
    bool ok = flow_init(&f, sys, sol, rq, err);
    if (ok) {
        r->initial = sga_calloc((size_t)f.n + 1, sizeof *r->initial);
        ok = start(&f, sys, sol, rq, r->initial, &r->moved, err)
             && field_begin(&f.field, rq->start, r->initial, err) && integrate(&f, sol, rq, r, err);
    }
    if (ok) {
        r->gauge = !sol->free_columns ? "none" : rq->rates ? "rates, then least norm" : "least norm";
        if (rq->rates && sol->free_columns <= rq->rates)
            r->gauge = "rates";
    } else if (!err->stage[0]) {
        memcpy(err->stage, "trajectory", 11);
    }
    flow_clear(&f);
    if (!ok)
        traj_result_clear(r);
    return ok;
}

void traj_result_clear(struct traj_result *r)
{
    free(r->initial);
    free(r->t);
    free(r->value);
    free(r->error);
    free(r->happening);
    free(r->happened_value);
    *r = (struct traj_result){ 0 };
}
