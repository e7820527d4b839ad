/* A solved system as the callbacks of an integrator: field, projection, outputs, events. */
#include "flow.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "bands.h"
#include "charts.h"
#include "field.h"
#include "flow_series.h"
#include "gauge_choice.h"
#include "inputs.h"
#include "jacobian.h"
#include "leap.h"
#include "manifold.h"
#include "mem.h"
#include "ode.h"
#include "reduction.h"
#include "redundant.h"
#include "signals.h"
#include "sizes.h"
#include "system.h"
#include "tape.h"
#include "variation_turn.h"
#include "whole.h"

/* From here on series are faster than other methods where they are short programs: measured over the references. */
#define FAST_RTOL 1.1e-7

static bool rhs(void *ctx, double t, const double *x, double *dx)
{
    struct flow *f = ctx;
    f->given->broken = -1;
    f->no_value = f->thrown = false;
    if (f->charts && f->charts->stop) {
        f->field->rank_lost = true;
        return false;
    }
    return field_eval(f->field, t, x, dx);
}

static bool code(void *ctx, struct ode_code *c)
{
    const struct flow *f = ctx;
    return !(f->charts && f->charts->stop) && field_code(((struct flow *)ctx)->field, c);
}

static bool stages(void *ctx, const struct sga_stages *plan, struct sga_stage_code *c)
{
    const struct flow *f = ctx;
    return !(f->charts && f->charts->stop) && field_stages(((struct flow *)ctx)->field, plan, c);
}

static bool code_holds(void *ctx, int calls)
{
    return field_code_holds(((const struct flow *)ctx)->field, calls);
}

bool flow_valued(struct flow *f, double t, const double *x)
{
    if (!f->valued)
        return true;
    memcpy(f->in, x, (size_t)f->n * sizeof *x);
    f->in[f->n] = t;
    f->no_value = !num_tape_eval(f->valued, f->in, f->value);
    for (int i = 0; i < num_tape_roots(f->valued) && f->no_value; i++)
        if (!isfinite(f->value[i])) {
            f->lost_value = i;
            f->lost_value_t = t;
        }
    return !f->no_value;
}

/* The correction is the least one in units of the error allowed: a rounding of a large
 * variable must not be paid for by a small one. What was given holds there too, or the point is refused. */
static bool project(void *ctx, double t, double *x, const double *scale, double *moved, double *residual)
{
    struct flow *f = ctx;
    int n = f->n;
    bool ok = true;
    *moved = *residual = 0;
    bool whole = f->field->whole && whole_project(f->field->whole, t, x, scale, moved, &f->manifold->raw);
    if (f->manifold->c && !whole && !manifold_chord(f->manifold, t, x, scale, moved)) {
        double sum = 0;
        sga_copy(f->in, x, n);
        ok = manifold_project(f->manifold, t, x, scale, NULL, 8, NULL, NULL, NULL);
        for (int j = 0; j < n; j++) {
            double d = (x[j] - f->in[j]) / scale[j];
            sum += d * d;
        }
        *moved = sqrt(sum);
    }
    f->off = !ok && f->manifold->c && manifold_residual(f->manifold, t, x, scale, NULL) >= 0;
    f->thrown = !ok && fabs(t - f->thrown_t) <= 1e-6 * fmax(fabs(t), fabs(t - f->field->begin_t));
    *moved /= n ? sqrt(n) : 1;
    *residual = f->manifold->c ? f->manifold->raw : 0;
    return ok && flow_valued(f, t, x) && given_hold(f->given, t, x, scale) && field_follows(f->field, t, x);
}

/* Derivatives of what does not jump may jump themselves, as constraints bend: so that the motion's own variables can be had, these are left free where
 * they cannot stay. By how much they jump is told after that (variation_turned). */
static bool jump_with_derivatives(struct flow *f, double t, double *x)
{
    size_t base = (size_t)f->turn->base;
    unsigned char *held = memcpy(sga_calloc((size_t)f->n + 1, 1), f->moving, base);
    bool ok = manifold_jump(f->manifold, t, x, held);
    free(held);
    return ok;
}

bool flow_jump(struct flow *f, double t, double *x)
{
    return manifold_jump(f->manifold, t, x, f->moving) || (f->turn && jump_with_derivatives(f, t, x)) || leap_over(f, t, x);
}

static bool jump(void *ctx, double t, double *x)
{
    struct flow *f = ctx;
    if (!flow_jump(f, t, x)) {
        f->thrown_t = manifold_residual(f->manifold, t, x, NULL, NULL) >= 0 ? t : NAN;
        return false;
    }
    return flow_valued(f, t, x) && field_follows(f->field, t, x);
}

static bool slope(void *ctx, double t, const double *x, double *value)
{
    struct flow *f = ctx;
    return f->charts && f->charts->pattern ? charts_slope(f, t, x, value) : field_slope(f->field, t, x, value);
}

static bool taylor(void *ctx, double t, const double *x, int order, double scale, double *series, double *reach)
{
    struct flow *f = ctx;
    return !(f->charts && f->charts->stop) && series_along(f->series, f->field, t, x, order, scale, series, reach);
}

/* The columns of a sample. */
void flow_output(void *ctx, double t, const double *x, double *y)
{
    struct flow *f = ctx;
    memcpy(f->in, x, (size_t)f->n * sizeof *x);
    f->in[f->n] = t;
    num_tape_eval(f->output, f->in, y);
}

static enum ode_reason why(void *ctx)
{
    struct flow *f = ctx;
    if (f->no_value)
        return ODE_LEFT_DOMAIN;
    bool lost = f->given->broken >= 0 || f->thrown || (f->off && !f->field->rank_lost && !f->field->contradiction);
    f->off = false;            /* of one projection */
    if (lost)
        return ODE_CONSTRAINT_LOST;
    return f->field->rank_lost || f->field->contradiction ? ODE_SINGULAR : ODE_LEFT_DOMAIN;
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

static void surfaces(void *ctx, double t, const double *x, double *g)
{
    struct flow *f = ctx;
    memcpy(f->in, x, (size_t)f->n * sizeof *x);
    f->in[f->n] = t;
    num_tape_eval(f->surface, f->in, g);
}

void flow_hold(void *ctx, const signed char *side)
{
    struct flow *f = ctx;
    if (f->charts)
        f->charts->side = side;
    field_hold(f->field, side);
    num_jacobian_hold(f->manifold->jac, side);
    num_tape_hold(f->surface, side);
    given_sides(f->given, side);
    if (f->turn) {
        num_jacobian_hold(f->turn->jac, side);
        num_tape_hold(f->turn->slope, side);
    }
    if (f->series->jet)
        num_jet_hold(f->series->jet, f->field->plain);
}

static void band(void *ctx, double t, const double *x, double *a)
{
    struct flow *f = ctx;
    memcpy(f->in, x, (size_t)f->n * sizeof *x);
    f->in[f->n] = t;
    num_tape_eval(f->band, f->in, a);
}

/* All that the motion is made of, in a list (malloced): rows, field, constraints, rates, events. */
static expr_id *expressions(const struct flow *f, const struct sga_solution *sol, const struct traj_request *rq, int *count)
{
    expr_id *root;
    int at = sys_expressions(f->sys, &root), n = f->n, c = sol->constraints;
    root = sga_realloc(root, (size_t)(at + n + c + rq->rates + rq->events + 1) * sizeof *root);
    for (int j = 0; j < n; j++)
        root[at++] = f->field->root[j];
    for (int i = 0; i < c; i++)
        root[at++] = sol->constraint[i].expr;
    for (int k = 0; k < rq->rates; k++)
        root[at++] = rq->rate[k].rate;
    for (int k = 0; k < rq->events; k++)
        root[at++] = rq->event[k].expression;
    *count = at;
    return root;
}

/* What steps could pass over unseen: functions of time, and bands. */
static bool look_for_pulses(struct flow *f, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err)
{
    expr_id *argument;
    int count;
    expr_id *root = expressions(f, sol, rq, &count);
    inputs_examine(f->inputs, f->sys, rq, root, count);
    f->bands = bands_find(f->sys->store, root, count - rq->events, &argument);
    free(root);
    int *inputs = field_inputs(f->sys);
    if (f->bands)
        f->band = num_tape_new(f->sys->store, argument, f->bands, inputs, f->n + 1, err);
    free(inputs);
    free(argument);
    return !f->bands || f->band;
}

bool flow_init(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol,
               const struct traj_request *rq, struct sga_error *err)
{
    int n = sys->variables;
    *f = (struct flow){ .n = n, .sys = sys, .lost_value = -1, .thrown_t = NAN,
                        .manifold = sga_calloc(1, sizeof *f->manifold), .field = sga_calloc(1, sizeof *f->field), .series = sga_calloc(1, sizeof *f->series), .given = sga_calloc(1, sizeof *f->given),
                        .inputs = sga_calloc(1, sizeof *f->inputs), .sizes = sga_calloc(1, sizeof *f->sizes) };
    sizes_init(f->sizes, sys, rq);
    f->knot = signals_knots(sys, rq, &f->knots);
    if (!field_init(f->field, sys, sol, rq, f->manifold, err) || !manifold_init(f->manifold, sys, sol, field_switches(f->field), err))
        return false;
    f->manifold->unit = f->sizes->weight;
    f->field->unit = f->sizes->uneven_rows ? f->sizes->row : NULL;
    const struct num_switches *w = field_switches(f->field);
    if (!look_for_pulses(f, sol, rq, err))
        return false;
    f->moving = sga_calloc((size_t)n + 1, 1);
    for (int i = 0; i < sys->rows; i++)
        for (int k = 0; k < sys->row[i].entries; k++)
            f->moving[sys->row[i].entry[k].col] = 1;
    bool follow = !w && !rq->turns && (!rq->events || rq->event_side);       /* of a piece: an event whose function jumps over 0 happens there */
    if ((!rq->no_motion && !signals_continuous(sys, sol, rq, f->field->root, follow ? f->moving : NULL, err)) || !given_init(f->given, sys, sol, w, f->sizes->weight, rq->budget, err))
        return false;
    f->in = sga_malloc((size_t)(n + 1) * sizeof *f->in);
    if (f->manifold->c && !rq->turns && !leap_init(&f->leap, sys, w, err))
        return false;
    if (rq->turns && w) {
        f->turn = sga_calloc(1, sizeof *f->turn);
        if (!variation_turn_init(f->turn, f, rq, err))
            return false;
    }
    if (!rq->outputs && !rq->events && !rq->valueds && !w)
        return true;
    int *inputs = sga_malloc((size_t)(n + 1) * sizeof *inputs);
    for (int j = 0; j < n; j++)
        inputs[j] = sys->variable[j].symbol;
    inputs[n] = sys->time;
    bool ok = !rq->outputs || (f->output = num_tape_new(sys->store, rq->output, rq->outputs, inputs, n + 1, err));
    ok = ok && (!w || (f->surface = num_tape_new_switched(sys->store, w, w->argument, w->count, inputs, n + 1, err)));
    ok = ok && (!rq->valueds || (f->valued = num_tape_new(sys->store, rq->valued, rq->valueds, inputs, n + 1, err)));
    f->value = sga_malloc((size_t)(rq->valueds + 1) * sizeof *f->value);
    ok = ok && (!rq->events || event_tape(f, sys, rq, inputs, err));
    free(inputs);
    return ok;
}

void flow_clear(struct flow *f)
{
    charts_clear(f);
    if (f->manifold)
        manifold_clear(f->manifold);
    if (f->field)
        field_clear(f->field);
    free(f->manifold);
    free(f->field);
    whole_free(f->beside);
    series_clear(f->series);
    given_clear(f->given);
    free(f->noise);
    free(f->moving);
    inputs_clear(f->inputs);
    sizes_clear(f->sizes);
    num_tape_free(f->surface);
    leap_clear(f->leap);
    if (f->turn)
        variation_turn_clear(f->turn);
    free(f->turn);
    num_tape_free(f->band);
    num_tape_free(f->output);
    num_tape_free(f->event);
    num_tape_free(f->valued);
    free(f->value);
    free(f->spec);
    free(f->in);
    free(f->knot);
    free(f->series);
    free(f->given);
    free(f->inputs);
    free(f->sizes);
}

static void enter(void *ctx, double from, double to)
{
    struct flow *f = ctx;
    if (f->charts && from == f->charts->start)
        charts_begin(f);
    if (f->sys->signals)
        signals_between(f->sys, from, to);
}

/* Sides are taken there. */
static void begins(void *ctx, double t) { ((struct flow *)ctx)->field->start_t = t; }

/* What each step asks for. Not the rows that define the field: they are asked where that fails. */
static void allow_code(struct flow *f, struct sga_exec *exec, struct num_jet_programs *programs)
{
    num_tape_compile(f->field->direct, exec);
    if (f->field->guard)
        num_tape_compile(f->field->guard, exec);
    f->series->memory = exec;
    f->series->programs = programs;
    num_jacobian_compile(f->manifold->jac, exec);
    if (f->field->slope)
        num_jacobian_compile(f->field->slope, exec);
    if (!f->field->fast) {
        num_tape_compile(f->field->general, exec);
        num_jacobian_compile(f->field->jac, exec);
    }
    if (f->surface)
        num_tape_compile(f->surface, exec);
    if (f->band)
        num_tape_compile(f->band, exec);
    if (f->output)
        num_tape_compile(f->output, exec);
    if (f->event)
        num_tape_compile(f->event, exec);
}

/* Rates may fix less than their number, so it is the rank that tells what is left. */
const char *flow_gauge(const struct flow *f, const struct traj_request *rq)
{
    return traj_gauge_text(rq->conditions, rq->rates > 0, f->field->rank < f->n);
}

static bool taken(void *ctx, double t, double *x)
{
    struct flow *f = ctx;
    field_keep_sides(f->field, t, x);
    return charts_choose(f, t, x);
}

static bool along(void *ctx, const struct ode_path *path) { return field_along(((struct flow *)ctx)->field, path); }

static bool over(void *ctx, double *t)
{
    const struct field *f = ((const struct flow *)ctx)->field;
    *t = f->fell_t;
    return f->over;
}

static void otherwise(void *ctx)
{
    struct field *f = ((struct flow *)ctx)->field;
    field_forget_trial(f);
    f->lost_pivot = -1;
    f->rank_lost = false;
}

static void refused(void *ctx) { field_forget_trial(((struct flow *)ctx)->field); }

/* A reduced field that divides by what may vanish: beside a zero of it (slow manifolds run into folds so) the field changes so fast that the stages of
 * implicit steps are found on the equations alone. Where these have no constraints (whose branches steps could leave), no bends and no sides, and leave
 * nothing to choose. And large systems, where a step holds its constraints by the same Newton iteration: the field of what they define has the
 * derivatives of their neighbours' fields in it, and its steps leave them by what stiff components are missed by. */
static bool has_equations(const struct flow *f)
{
    const struct field *field = f->field;
    bool plain = !field->whole && !field->reduced && !field->rates && !field->choice->field && field->generic_rank == f->n;
    bool large = f->n >= WHOLE_VARIABLES && f->manifold->c, divides = f->n < WHOLE_VARIABLES && !f->manifold->c && field->chosen > field->sides;
    return plain && (large || divides) && !field->switches->count && !f->sys->signals && !f->turn && !f->charts;
}

static struct whole *whole_of(const struct flow *f) { return f->field->whole ? f->field->whole : f->beside; }

static bool residual(void *flow, double t, const double *x, const double *v, double *r) { return whole_residual(whole_of(flow), t, x, v, r); }

static bool matrices(void *flow, double t, const double *x, const double *v, double *mass, double *slope)
{
    return whole_matrices(whole_of(flow), t, x, v, mass, slope);
}

static const struct ode_implicit implicit = { .residual = residual, .matrices = matrices };

static const struct ode_implicit *equations(void *ctx)
{
    struct flow *f = ctx;
    if (!f->beside_asked)
        f->beside = whole_new(f->field, f->field->home_t, f->field->home);
    if (!f->field->M)
        field_rows_forget(f->field);      /* room for whole rows is no room for the elimination */
    f->beside_asked = true;
    return f->beside ? whole_equations(f->beside, &implicit) : NULL;
}

void flow_code(struct flow *f, const struct traj_request *rq) { allow_code(f, rq->budget ? rq->budget->exec : NULL, rq->programs); }

struct ode_problem flow_problem(struct flow *f, const struct traj_request *rq)
{
    flow_code(f, rq);
    bool watched = f->field->guards || (!f->field->whole && (f->field->pivots || f->charts || f->field->switches->count));
    struct lin_sparse *pattern = f->charts && f->charts->count > 1 ? f->charts->pattern : f->field->pattern;
    assert(!(f->field->whole && f->field->fast));       /* the equations as they stand are in place of all else */
    return (struct ode_problem){ .n = f->n, .ctx = f, .rhs = rhs, .code = code, .stages = stages, .code_holds = code_holds,
                                 .project = f->manifold->c || f->given->count || f->valued ? project : NULL, .why = why,
                                 .jump = f->manifold->c ? jump : NULL,
                                 .implicit = f->field->whole ? whole_equations(f->field->whole, &implicit) : NULL,
                                 .equations = has_equations(f) ? equations : NULL, .otherwise = otherwise,
                                 .pattern = pattern, .jacobian = pattern ? slope : NULL,
                                 .taylor = f->field->fast ? taylor : NULL,
                                 .taylor_rtol = series_fast(f->field) ? FAST_RTOL : 0,
                                 .breaks = f->knot, .break_count = f->knots, .enter = f->sys->signals || f->charts ? enter : NULL, .begins = f->charts ? NULL : begins,
                                 .taken = watched || (f->manifold->c && !f->field->whole) ? taken : NULL, .refused = watched ? refused : NULL, .over = watched ? over : NULL, .along = f->field->guards ? along : NULL,
                                 .switches = f->field->switches->count, .switching = surfaces, .hold = flow_hold,
                                 .turned = f->turn ? variation_turned : NULL,
                                 .piece = f->inputs->piece, .pieces = f->inputs->count,
                                 .noise = flow_noise, .bands = f->bands, .band = band,
                                 .cost = 4.0 * num_tape_length(f->field->direct),
                                 .outputs = rq->outputs, .output = rq->outputs ? flow_output : NULL,
                                 .events = rq->events, .event_spec = f->spec, .event_side = rq->event_side, .event = event };
}
