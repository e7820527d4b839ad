/* One solution in double-double: from point to point by the steps that a method makes, with
 * samples inside of them, to the last time or to where and why it ends. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "charts.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "inputs.h"
#include "knots.h"
#include "mem.h"
#include "ode.h"
#include "precise.h"
#include "precise_march.h"
#include "precise_series.h"
#include "redundant.h"
#include "sizes.h"
#include "tolerance.h"
#include "trajectory.h"

/* Steps this small against the time passed end a march that shrinks them. */
#define SMALLEST 1e-25
#define SMALLEST_TO_CHANGE 1e-31
#define SMALLEST_IMPLICIT 1e-14        /* beside switches series are tried from there on, which go over roots on their borders */
/* Places of ranks and domains are found in double. */
#define LEAST_STEP 1e-290      /* smaller numbers lose digits */
#define SMALLEST_REFUSED 4e-16
/* Steps of this part of the time passed tend to no singularity; near one derivatives are so many times larger. */
#define CALM 1e-3
#define AT_ENDING 1e-7          /* of the way made: a sample this near to an ending is not asked for */
#define GROWN 30.0
#define HUGE_STATE 1e280        /* products of halves overflow not far beyond */
#define ROUNDINGS_ON 16.0      /* of time */
#define LOOK_EVERY 500
#define LOOKS 4
#define BEYOND_HOPE 2.0

int precise_parts(const struct precise *p)
{
    enum { PARTS = 3 };
    return 1 + p->solution % PARTS;
}

void precise_set_scale(struct precise_march *m, const num_dd *x)
{
    for (int j = 0; j < m->n; j++)
        m->scale[j] = fmax(sga_allowed((struct sga_tolerance){ m->rtol, m->atol }, m->p->flow->sizes->unit[j], x[j].hi), 1e-300);
}

/* Root mean square in units of the error allowed; v may be so large that squares overflow. */
double precise_weighted(const struct precise_march *m, const num_dd *v)
{
    double most = 0, sum = 0;
    for (int j = 0; j < m->n; j++)
        most = fmax(most, fabs(v[j].hi) / m->scale[j]);
    if (!(most > 0) || isinf(most))
        return most;
    for (int j = 0; j < m->n; j++)
        sum += pow(fabs(v[j].hi) / m->scale[j] / most, 2);
    return most * sqrt(sum / m->n);
}

num_dd precise_rest(const struct precise_march *m)
{
    return num_dd_sub(m->p->time[m->p->rq->samples - 1], m->here.t);
}

static num_dd goal(const struct precise_march *m)
{
    const struct precise *p = m->p;
    return m->passed_knots < p->knots->count ? p->knot[m->passed_knots] : p->time[p->rq->samples - 1];
}

num_dd precise_goal_rest(const struct precise_march *m) { return num_dd_sub(goal(m), m->here.t); }

num_dd precise_after(const struct precise_march *m, num_dd h)
{
    return num_dd_sub(precise_goal_rest(m), h).hi == 0 ? goal(m) : num_dd_add(m->here.t, h);
}

/* The field at q in double; or, where that has none by roundings (just inside the domain of a root), a little further on. */
static bool has_field(struct precise_march *m, const struct precise_point *q)
{
    struct field *f = m->p->flow->field;
    for (int j = 0; j < m->n; j++)
        m->xd[j] = q->x[j].hi;
    bool ok = field_eval(f, q->t.hi, m->xd, m->fd);
    if (ok || f->rank_lost || f->contradiction || !m->sides.count || m->sides.natural)
        return ok;
    double on = ROUNDINGS_ON * DBL_EPSILON * m->direction * fmax(fabs(q->t.hi), fabs(num_dd_sub(q->t, m->p->start).hi));
    double *x = sga_malloc(((size_t)m->n + 1) * sizeof *x);
    for (int j = 0; j < m->n; j++)
        x[j] = m->xd[j] + on * m->along[j];
    ok = field_eval(f, q->t.hi + on, x, m->fd);
    free(x);
    return ok;
}

bool precise_allowed(struct precise_march *m, const struct precise_point *q)
{
    struct flow *f = m->p->flow;
    if (has_field(m, q)) {
        m->why = ODE_LEFT_DOMAIN;
        if (!flow_valued(f, q->t.hi, m->xd))
            return false;
        m->why = ODE_CONSTRAINT_LOST;
        if (!given_hold(f->given, q->t.hi, m->xd, m->scale) || field_follows(f->field, q->t.hi, m->xd))
            return f->given->broken < 0;
    }
    m->why = f->field->rank_lost || f->field->contradiction ? ODE_SINGULAR : ODE_LEFT_DOMAIN;
    return false;
}

/* What was given holds at a sample. */
static bool given_at(struct precise_march *m, num_dd t, const num_dd *x)
{
    for (int j = 0; j < m->n; j++)
        m->xd[j] = x[j].hi;
    return flow_valued(m->p->flow, t.hi, m->xd) && given_hold(m->p->flow->given, t.hi, m->xd, m->scale);
}

/* How far the projection may move a point without spoiling it. */
static double most_moved(const struct precise_march *m, const struct precise_point *q)
{
    double sum = 0;
    for (int j = 0; j < m->n; j++)
        sum += pow(NUM_DD_EPSILON * q->x[j].hi / m->scale[j], 2);
    return 10 + 1000 * (m->n ? sqrt(sum / m->n) : 0);
}

bool precise_settle(struct precise_march *m, struct precise_point *q)
{
    double moved, residual;
    m->why = ODE_LEFT_DOMAIN;
    if (!precise_project(m->p, q->t, q->x, m->scale, NULL, &moved, &residual))
        return false;
    m->why = ODE_CONSTRAINT_LOST;
    return moved <= most_moved(m, q) && precise_allowed(m, q);
}

bool precise_arrive(struct precise_march *m) { return precise_settle(m, &m->there); }

/* Samples up to the end, in the last step. False: one of them cannot be projected. */
static bool deliver(struct precise_march *m, num_dd end)
{
    const struct precise *p = m->p;
    for (; m->next < p->rq->samples; m->next++) {
        num_dd left = num_dd_sub(end, p->time[m->next]);
        double moved, residual;
        if (left.hi * m->direction < 0)
            return true;
        num_dd *x = m->path->sample + (size_t)m->next * (size_t)m->n;
        m->method->value(m->state, m, p->time[m->next], x);
        if (!precise_project(m->p, p->time[m->next], x, m->scale, NULL, &moved, &residual) || !(moved <= most_moved(m, &m->there))
            || !given_at(m, p->time[m->next], x))
            return false;
        m->path->residual = fmax(m->path->residual, residual);
    }
    return true;
}

void precise_end(struct precise_march *m, enum ode_reason reason, const char *detail)
{
    assert(reason > ODE_NONE && reason < ODE_REASON_COUNT);      /* else it would pass for the last time */
    m->path->reason = reason;
    m->path->t = m->here.t.hi;
    snprintf(m->path->detail, sizeof m->path->detail, "%.255s", detail);
}

double precise_largest(const num_dd *x, int n)
{
    double most = 0;
    for (int j = 0; j < n; j++)
        most = fmax(most, fabs(x[j].hi));
    return most;
}

/* Derivatives are far larger than where the steps had not begun to shrink: the largest of them, 0 where there is none. And
 * *alone: it is so large against the state over the time passed that it has a scale of its own, which goes to 0. */
static double growing(const struct precise_march *m, double size, bool *alone)
{
    double passed = fabs(num_dd_sub(m->here.t, m->p->start).hi), most = 0;
    for (int j = 0; j < m->n && m->path->steps; j++)
        if (m->rate[j] > GROWN * m->calm[j])
            most = fmax(most, m->rate[j]);
    *alone = most * passed > 1e3 * fmax(fmax(size, m->first_size), 1e-300);
    return most;
}

static void end_refused(struct precise_march *m, bool refused)
{
    char text[200];
    bool alone;
    double size = precise_largest(m->here.x, m->n), rate = growing(m, size, &alone);
    if (!refused && m->choice.rescued == m->path->steps + 1 && m->choice.rescued_why == ODE_LEFT_DOMAIN) {     /* series went no further */
        refused = true;
        m->why = ODE_LEFT_DOMAIN;
    }
    if (size > HUGE_STATE) {
        snprintf(text, sizeof text, "the solution grows beyond the range of numbers (size %.3g at the end)", size);
        precise_end(m, ODE_BLOW_UP, text);
    } else if (rate > 0 && size > 1e3 * (m->first_size + 1) && !(refused && m->why == ODE_SINGULAR)) {
        snprintf(text, sizeof text, "the solution grows without bound (size %.3g at the end)", size);
        precise_end(m, ODE_BLOW_UP, text);
    } else if (alone && !(refused && m->why != ODE_LEFT_DOMAIN)) {
        snprintf(text, sizeof text, "the derivative grows without bound (size %.3g) while the solution stays at size %.3g", rate, size);
        precise_end(m, ODE_BLOW_UP, text);
    } else if (!refused) {
        precise_end(m, ODE_NOT_SMOOTH, "no step is small enough for the tolerance here: the field is not smooth, or the tolerance is too tight");
    } else {
        precise_end(m, m->why, m->why == ODE_SINGULAR ? "a rank drops here: the field or the constraints are singular"
                          : m->why == ODE_LEFT_DOMAIN ? "the vector field has no series beyond this time"
                          : "no point near the solution satisfies the constraints beyond this time");
    }
}

/* Steps are given up where something grows on a scale of its own that goes to 0. False: nothing does. */
static bool end_growing(struct precise_march *m)
{
    char text[200];
    int which = 0;
    bool alone;
    double size = precise_largest(m->here.x, m->n), rate = growing(m, size, &alone);
    if (!(rate > 0 && alone))
        return false;
    for (int j = 1; j < m->n; j++)
        which = m->rate[j] > m->rate[which] ? j : which;
    snprintf(text, sizeof text, "the derivative grows without bound (size %.3g) while the solution stays at size %.3g", rate, size);
    precise_end(m, ODE_BLOW_UP, text);
    m->path->left = ode_left_to_grow(m->here.x[which].hi, m->rate[which]);
    return true;
}

/* At this pace the stop would take far more steps than are allowed, look after look? */
static bool out_of_reach(struct precise_march *m)
{
    double progress = fabs(num_dd_sub(m->here.t, m->look_t).hi);
    double rest = fabs(precise_rest(m).hi);
    m->hopeless = rest / fmax(progress, 1e-300) * LOOK_EVERY > BEYOND_HOPE * (double)m->p->limits.steps ? m->hopeless + 1 : 0;
    m->look_t = m->here.t;
    m->look_at += LOOK_EVERY;
    return m->hopeless >= LOOKS;
}

static bool may_go_on(struct precise_march *m)
{
    struct precise_path *q = m->path;
    struct sga_error err = { 0 };
    if (!sga_budget_ok(m->p->rq->budget, &err)) {
        precise_end(m, err.code == SGA_E_CANCELLED ? ODE_CANCELLED : ODE_TIME_LIMIT, err.detail);
        return false;
    }
    if (q->steps + q->refused >= m->p->limits.steps || m->work > m->p->limits.work) {
        precise_end(m, ODE_STEP_LIMIT, "the limit of steps was reached; ask for an earlier stop or larger tolerances");
        return false;
    }
    if (q->steps >= m->look_at && out_of_reach(m)) {
        if (end_growing(m))
            return false;
        precise_end(m, ODE_STEP_LIMIT, "the last time is out of reach: if the system is stiff, ask for the method \"auto\" or \"radau\"; "
               "otherwise for an earlier stop");
        return false;
    }
    return true;
}

/* The field where the march is, after a step of some size. */
static void take_rates(struct precise_march *m, double size)
{
    bool calm = size >= CALM * fabs(num_dd_sub(m->here.t, m->p->start).hi);
    for (int j = 0; j < m->n; j++) {
        m->calm[j] = calm ? fmax(m->calm[j], m->rate[j]) : m->calm[j];
        m->along[j] = m->fd[j];
        m->rate[j] = fabs(m->fd[j]);
    }
}

static bool begin(struct precise_march *m)
{
    const struct precise *p = m->p;
    double moved, residual, span = fabs(num_dd_sub(p->time[p->rq->samples - 1], p->start).hi);
    memcpy(m->here.x, p->x, (size_t)m->n * sizeof *p->x);
    m->here.t = m->look_t = p->start;
    m->look_at = LOOK_EVERY;
    m->path->t = p->start.hi;
    m->first_size = precise_largest(p->x, m->n);
    precise_set_scale(m, p->x);
    for (int j = 0; j < m->n && m->start_beside; j++)
        m->here.x[j] = num_dd_mul(m->here.x[j], (num_dd){ 1, j * 5 % 3 == 1 ? -NUM_DD_EPSILON : NUM_DD_EPSILON });
    m->why = ODE_CONSTRAINT_LOST;
    if (!precise_project(m->p, m->here.t, m->here.x, m->scale, NULL, &moved, &residual) || !precise_allowed(m, &m->here)) {
        end_refused(m, true);
        return false;
    }
    m->path->residual = residual;
    m->why = ODE_LEFT_DOMAIN;
    for (; m->next < p->rq->samples && num_dd_sub(p->time[m->next], p->start).hi == 0; m->next++)
        memcpy(m->path->sample + (size_t)m->next * (size_t)m->n, m->here.x, (size_t)m->n * sizeof *p->x);
    if (m->next == p->rq->samples)
        return false;
    take_rates(m, 0);
    if (m->method->begin(m->state, m, span) || precise_begin_without_series(m, span))
        return true;
    if (m->path->reason == ODE_NONE)
        end_refused(m, true);
    return false;
}

/* A size that reaches into no piece of the inputs further than that allows. */
static num_dd within_pieces(struct precise_march *m, num_dd h)
{
    const struct inputs *q = m->p->flow->inputs;
    double size = fabs(h.hi), most = ode_within(q->piece, q->count, &m->next_piece, m->here.t.hi, m->direction, size);
    return most < size ? num_dd_of(m->direction * most) : h;
}

/* The motion has come to here; perhaps it goes on in another chart. False: the march is over. */
static bool settled_in_chart(struct precise_march *m, double size)
{
    struct flow *f = m->p->flow;
    for (int j = 0; j < m->n; j++)
        m->xd[j] = m->here.x[j].hi;
    if (!charts_choose(f, m->here.t.hi, m->xd)) {
        if (f->charts && f->charts->stop)
            precise_end(m, ODE_SINGULAR, "other pivots are taken");
        return m->path->reason == ODE_NONE;
    }
    double moved, residual;
    precise_follow_chart(m->p);
    precise_choice_renew(m);
    m->why = ODE_CONSTRAINT_LOST;
    if (!precise_project(m->p, m->here.t, m->here.x, m->scale, NULL, &moved, &residual)) {
        end_refused(m, true);
        return false;
    }
    if (m->sides.count)
        precise_hold(m);
    if (m->method->begin(m->state, m, fmin(size, fabs(precise_rest(m).hi))))
        return true;
    if (m->path->reason == ODE_NONE)
        end_refused(m, true);
    return false;
}

/* In double, as all that is looked for. */
static void place(const void *march, double s, double *x)
{
    const struct precise_march *m = march;
    num_dd way = num_dd_sub(m->there.t, m->here.t), *at = m->sought;
    if (s == 0 || s == 1)
        at = s == 0 ? m->here.x : m->there.x;
    else
        m->method->value(m->state, m, num_dd_add(m->here.t, num_dd_scale(way, s)), at);
    for (int j = 0; j < m->n; j++)
        x[j] = at[j].hi;
}

static double error_of(const void *march, int j)
{
    const struct precise_march *m = march;
    return (1 + (double)m->path->steps) * m->scale[j];
}

/* Whether nothing inside the step ends the motion. */
static bool goes_on_along(struct precise_march *m)
{
    struct ode_path path = { .march = m, .t = m->here.t.hi, .h = num_dd_sub(m->there.t, m->here.t).hi, .at = place, .error = error_of, .budget = m->p->rq->budget };
    if (field_along(m->p->flow->field, &path))
        return true;
    m->why = ODE_SINGULAR;
    return false;
}

/* Whether the field ends for good just beyond the present point, and no sample lies between. */
static bool over(struct precise_march *m)
{
    struct field *f = m->p->flow->field;
    double t = f->fell_t, near = fmax(AT_ENDING, 0.1 * m->rtol) * fabs(num_dd_sub(m->here.t, m->p->start).hi);
    bool ended = m->why == ODE_SINGULAR && f->over && (t - m->p->time[m->next].hi) * m->direction <= near;
    field_forget_trial(f);
    if (ended) {
        precise_end(m, ODE_SINGULAR, "a rank drops here: the field or the constraints are singular");
        m->path->t = t;
    }
    return ended;
}

/* One step, or a try of one. False: the march is over. */
static bool step(struct precise_march *m, double *cut)
{
    num_dd h = within_pieces(m, m->method->size(m->state, m, *cut));
    if (m->band_cut > 0 && fabs(h.hi) > m->band_cut)
        h = num_dd_of(m->direction * m->band_cut);
    h = precise_within_knots(m, h);
    double size = fabs(h.hi), passed = fmax(fabs(m->here.t.hi), fabs(num_dd_sub(m->here.t, m->p->start).hi));
    bool refused = *cut < 1 && m->why != ODE_NONE, huge = precise_largest(m->here.x, m->n) > HUGE_STATE;
    double since = fabs(num_dd_sub(m->here.t, m->p->start).hi);
    if (m->sides.count && size < SMALLEST_IMPLICIT * since && size >= SMALLEST * since && precise_rescue(m)) {
        *cut = 1;
        return true;
    }
    if (m->path->reason != ODE_NONE)
        return false;
    double least = refused ? SMALLEST_REFUSED : m->sides.count ? SMALLEST_TO_CHANGE : SMALLEST;
    if (huge || !(size >= fmax(least * passed, LEAST_STEP))) {
        if (!huge && (!refused || (m->sides.count && m->why == ODE_LEFT_DOMAIN)) && precise_rescue(m)) {
            *cut = 1;
            return true;
        }
        if (!huge && (!refused || m->why == ODE_LEFT_DOMAIN) && precise_sides_cross(m, size)) {
            *cut = 1;
            return true;
        }
        if (m->path->reason == ODE_NONE)
            end_refused(m, refused);
        return false;
    }
    assert(h.hi * m->direction > 0);
    enum precise_outcome o = m->method->attempt(m->state, m, h, cut);
    double pulse = o == PRECISE_TAKEN ? precise_band(m, h) : 2;
    if (pulse < 1) {
        m->band_cut = pulse * size;
        m->path->refused++;
        *cut = 1;
        return true;
    }
    if (o == PRECISE_TAKEN && !goes_on_along(m)) {
        o = PRECISE_REFUSED;
        *cut *= 0.5;
    }
    num_dd end = m->there.t;
    enum precise_stop stop = o == PRECISE_TAKEN ? precise_watch(m, &end) : PRECISE_GOES_ON;
    if (o == PRECISE_TAKEN && (stop == PRECISE_NO_PLACE || !deliver(m, end))) {
        o = PRECISE_REFUSED;
        *cut *= 0.5;
    }
    if (o != PRECISE_TAKEN) {
        m->path->refused++;
        if (o == PRECISE_TOO_LARGE)
            m->why = ODE_NONE;
        return o != PRECISE_REFUSED || !over(m);
    }
    assert(num_dd_sub(m->there.t, m->here.t).hi * m->direction > 0);
    m->path->steps++;
    m->band_cut = 0;
    m->choice.steps[m->method == &precise_radau]++;
    precise_watched(m);
    if (stop != PRECISE_GOES_ON) {
        if (stop == PRECISE_STOPPED)
            precise_end(m, ODE_EVENT, "an event that stops the motion");
        else
            precise_end(m, ODE_STEP_LIMIT, "more events were found than a result may hold");
        m->path->t = end.hi;
        return false;
    }
    if (m->next == m->p->rq->samples)
        return false;
    struct precise_point before = m->here;
    m->here = m->there;
    m->there = before;
    for (int j = 0; j < m->n; j++)
        m->xd[j] = m->here.x[j].hi;
    field_keep_sides(m->p->flow->field, m->here.t.hi, m->xd);
    if (!m->method->accepted(m->state, m))
        return false;
    take_rates(m, size);
    if (!settled_in_chart(m, size) || !precise_pass_knot(m, size))
        return false;
    precise_choose(m, size);
    *cut = 1;
    return m->path->reason == ODE_NONE;
}

static void march(struct precise *p, double rtol, double atol, bool beside, bool start_beside, struct precise_path *path)
{
    struct precise_march m = { .p = p, .path = path, .n = p->n, .rtol = rtol, .atol = atol, .beside = beside, .start_beside = start_beside };
    double cut = 1;
    charts_begin(p->flow);
    precise_follow_chart(p);
    *path = (struct precise_path){ .t = p->start.hi };
    m.direction = num_dd_less(p->time[p->rq->samples - 1], p->start) ? -1 : 1;
    path->sample = sga_calloc((size_t)p->rq->samples * (size_t)m.n + 1, sizeof *path->sample);
    m.here.x = sga_calloc(3 * (size_t)m.n + 1, sizeof *m.here.x);
    m.there.x = m.here.x + m.n;
    m.sought = m.there.x + m.n;
    num_dd *states = m.here.x;
    m.scale = sga_calloc(6 * (size_t)m.n + 1, sizeof *m.scale);
    m.xd = m.scale + m.n;
    m.fd = m.xd + m.n;
    m.rate = m.fd + m.n;
    m.calm = m.rate + m.n;
    m.along = m.calm + m.n;
    precise_knots_begin(&m);
    precise_sides_begin(&m);
    precise_choice_begin(&m);
    if (p->flow->charts && p->flow->charts->stop)
        precise_end(&m, ODE_SINGULAR, "other pivots are taken");
    else if (begin(&m)) {
        precise_watch_begin(&m);
        while (may_go_on(&m) && step(&m, &cut)) { }
        precise_watch_end(&m);
    }
    path->count = m.next;
    assert(path->reason != ODE_NONE || path->count == p->rq->samples);      /* no end without a reason */
    if (path->reason == ODE_NONE)
        path->t = p->time[p->rq->samples - 1].hi;
    precise_choice_end(&m);
    precise_sides_end(&m);
    knots_leave(p->knots);
    free(states);
    free(m.scale);
}

void precise_march(struct precise *p, double rtol, double atol, bool beside, struct precise_path *path)
{
    march(p, rtol, atol, beside, beside, path);
    if (!beside || path->steps || path->reason != ODE_LEFT_DOMAIN)
        return;
    precise_path_clear(path);                      /* the start may lie on the border, and the point beside it beyond */
    march(p, rtol, atol, beside, false, path);
}
