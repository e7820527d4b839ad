/* The march from the start to the last time: attempt, accept, settle, sample, move on. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "companion.h"
#include "larger.h"
#include "march.h"
#include "mem.h"

#define BREAK_PART 0.41
#define ITERATED 0.1           /* of the error allowed: iterations of implicit steps leave less */
#define ENOUGH 0.3             /* of the time that is left */
#define FIRST_SERIES 1000.0    /* times longer than usual: a bound for the first step */

static void march_alloc(struct ode_march *m)
{
    size_t n = (size_t)m->p->n;
    m->memory = sga_calloc(11 * n + 1, sizeof *m->memory);
    double *at = m->memory;
    double **vectors[] = {&m->x, &m->carry, &m->f, &m->x1, &m->carry1, &m->f1, &m->dx, &m->scale, &m->last};
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++, at += n)
        *vectors[i] = at;
    m->work = at;
}

/* a + b = sum + *error, exactly (Knuth). */
static double two_sum(double a, double b, double *error)
{
    double s = a + b, v = s - a;
    *error = (a - (s - v)) + (b - v);
    return s;
}

/* Below this, steps are lost in the rounding of t. */
static double smallest_step(const struct ode_march *m)
{
    double range = sga_larger(fabs(m->start->t), fabs(m->stop));
    return 4 * DBL_EPSILON * sga_larger(fabs(m->t), sga_larger(DBL_EPSILON * range, 1e-300));
}

void ode_prepare_step(struct ode_march *m, double h)
{
    struct ode_step *s = &m->step;       /* one by one: a literal would be cleared as a whole first */
    s->n = m->p->n;
    s->t = m->t;
    s->t_low = m->t_low;
    s->h = h;
    s->x = m->x;
    s->f = m->f;
    s->rtol = m->o->rtol;
    s->atol = m->o->atol;
    s->unit = m->unit;
    s->dx = m->dx;
    s->x1 = m->x1;
    s->f1 = m->f1;
    s->f_end = NULL;
    s->log_error = NAN;
    s->error = s->error_order = s->dense_error = s->doubt = s->cost = s->retry = 0;
}

double ode_goal(const struct ode_march *m)
{
    return m->next_break < m->p->break_count ? m->p->breaks[m->next_break] : m->stop;
}

/* The motion goes on from the present time to the next break. */
static void enter(struct ode_march *m)
{
    double goal = ode_goal(m);
    assert((goal - m->t) * m->direction >= 0);       /* breaks are given in the order of the motion */
    m->piece = m->p->break_count ? fabs(goal - m->t) : INFINITY;
    if (m->choice.series_state)
        ode_taylor.forget(m->choice.series_state);       /* another piece has another series */
    if (m->p->enter)
        m->p->enter(m->p->ctx, m->t, goal);
}

/* At a break beyond which the constraints may be others: what may jump does. False: it cannot. Where switches are held nothing jumps here. */
static bool land(struct ode_march *m)
{
    const struct ode_problem *p = m->p;
    double residual, *old;
    if (!p->jump || !p->project || m->kinks)
        return true;
    old = sga_malloc(((size_t)p->n + 1) * sizeof *old);
    sga_copy(old, m->x, p->n);
    bool ok = ode_settle(m, m->t, m->x, 1, &residual);
    if (!ok) {
        sga_copy(m->x, old, p->n);
        ok = p->jump(p->ctx, m->t, m->x);
        ode_companion_lose(m->companion);
        for (int j = 0; j < p->n; j++)
            m->carry[j] = m->x[j] == old[j] ? m->carry[j] : 0;
    }
    free(old);
    return ok;
}

/* After a step that ended at a break: the field beyond it. False: ended. */
static bool pass_break(struct ode_march *m)
{
    if (m->next_break == m->p->break_count || m->t != m->p->breaks[m->next_break])
        return true;
    m->next_break++;
    assert(ode_march_sane(m));
    enter(m);
    if (!land(m)) {
        ode_end_at(m, ODE_CONSTRAINT_LOST, "the constraints jump here with a table, and what no equation differentiates cannot follow");
        return false;
    }
    if (!ode_kinks_enter(m))
        return false;
    if (ode_eval(&m->field, m->t, m->x, m->f)) {
        ode_kinks_look(m);
        return true;
    }
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}

/* The start projected, the samples at the start, the field there and a first step.
 * False: ended, or nothing is left to do. */
static bool begin(struct ode_march *m, double *h)
{
    double residual;
    int which;
    size_t n = (size_t)m->p->n;
    enter(m);
    if (m->p->begins)
        m->p->begins(m->p->ctx, m->t);
    memcpy(m->x, m->start->x, n * sizeof *m->x);
    for (size_t j = 0; m->beside && j < n; j++)
        m->x[j] *= j * 5 % 3 == 1 ? 1 - DBL_EPSILON : 1 + DBL_EPSILON;
    if (!ode_settle(m, m->t, m->x, INFINITY, &residual)) {
        ode_end_at(m, m->manifold_why, "the start does not satisfy the constraints, and cannot be moved onto them");
        return false;
    }
    m->res->start_moved = m->moved;
    m->res->start_residual = residual;
    ode_watch_start(m);
    m->start_size = ode_largest(m, m->x, &which);
    if (!ode_eval(&m->field, m->t, m->x, m->f)) {
        ode_end_at(m, m->field.why, "the vector field has no finite value at the start");
        return false;
    }
    m->start_rate = ode_largest(m, m->f, &which);
    for (; m->next < m->start->count && m->start->times[m->next] == m->t; m->next++) {
        memcpy(m->res->samples + (size_t)m->next * n, m->x, n * sizeof *m->x);
        m->res->max_residual = residual;
    }
    if (m->next == m->start->count)
        return false;
    ode_prepare_step(m, m->stop - m->t);
    *h = m->o->first_step > 0
             ? m->o->first_step
             : ode_first_step(&m->field, &m->step, m->method->error_order, m->level, m->work);
    if (m->method->series && !(m->o->first_step > 0))       /* which knows better, but not from everywhere */
        *h = fmin(FIRST_SERIES * *h, fabs(m->stop - m->t));
    if (!(m->o->first_step > 0))       /* far from time 0 derivatives by differences may be roundings */
        *h = fmax(*h, fmin(64 * smallest_step(m), fabs(m->stop - m->t)));
    return ode_kinks_start(m, *h);
}

/* The distance to the next sample that is not at the present point. */
static double sample_distance(const struct ode_march *m)
{
    return fabs((m->start->times[m->next] - m->t) - m->t_low);
}

/* A method whose polynomial is less accurate than its steps makes shorter steps where
 * samples lie inside of them, or steps that end at the samples, whichever are longer. */
static double fit_samples(const struct ode_march *m, double h, double *aim)
{
    double d = sample_distance(m);
    if (m->watch)
        return m->dense_ratio * h;
    if (m->dense_ratio >= 1 || d >= 2 * h)
        return h;
    if (d <= m->dense_ratio * h)
        return m->dense_ratio * h;
    *aim = m->start->times[m->next];
    double parts = ceil(d / (1.0001 * h)) + m->level;
    if (parts > 1)
        *aim = NAN;
    return d / parts;
}

/* Of the way from break to break, and of all of it, where the errors of steps depend on nothing but their sizes: series are of another order too. */
static double longest_piece(const struct ode_march *m)
{
    return m->method->series ? m->piece : fmin(m->piece, fabs(m->stop - m->start->t));
}

/* |h| cut so that the march ends on the stop, and not with a sliver of a step. *aim: where
 * the step is to end exactly, or NAN. */
static double cut(struct ode_march *m, double h, double *aim)
{
    double goal = ode_goal(m), rest = fabs((goal - m->t) - m->t_low);
    *aim = NAN;
    if (m->o->max_step > 0)
        h = fmin(h, m->o->max_step);
    if (m->level)       /* solutions that are compared take different steps, or their errors are the same: between breaks, other parts */
        h = fmin(h, longest_piece(m) * BREAK_PART / (0.4 + 0.6 * m->level));
    h = fit_samples(m, ode_within(m->p->piece, m->p->pieces, &m->next_piece, m->t, m->direction, h), aim);
    double kink = m->kinks ? ode_kinks_cut(m, h) : h;
    kink = m->bands ? ode_bands_cut(m, kink) : kink;
    if (kink < h && kink < rest) {      /* there and nowhere else, whatever is left behind it */
        *aim = NAN;
        return kink;
    }
    if (h * 1.01 < rest)
        return h * 2 > rest && isnan(*aim) ? rest / 2 : h;
    *aim = goal;
    return rest;
}

/* *h: the size asked for; the size taken, where the method made the step shorter. */
static enum ode_refusal attempt(struct ode_march *m, double *h, double aim, int *through)
{
    double residual = 0;
    ode_prepare_step(m, *h * m->direction);
    m->dense_checked = false;
    enum ode_outcome o = m->method->attempt(m->state, &m->field, &m->step);
    if (fabs(m->step.h) < *h)
        aim = NAN;
    *h = fabs(m->step.h);
    if (o != ODE_STEPPED)
        return o == ODE_NOT_SOLVED ? NOT_SOLVED : FIELD_REFUSED;
    m->t1 = two_sum(m->t, m->step.h + m->t_low, &m->t1_low);
    if (!isnan(aim)) {
        m->t1 = aim;
        m->t1_low = 0;
    }
    m->error = m->step.error;
    if (m->step.dense_error > m->error && (m->watch || ode_sample_inside(m)))
        m->error = m->step.dense_error;
    if (m->error > 1 && isfinite(m->error) && ode_late_error(m)) {
        m->error = m->step.error = m->step.dense_error = 0.1;
        m->step.log_error = NAN;
        m->late = true;
    }
    if (!(m->error <= 1)) {
        m->field.why = ODE_LEFT_DOMAIN;
        return isfinite(m->error) ? ERROR_TOO_LARGE : FIELD_REFUSED;
    }
    for (int j = 0; j < m->p->n; j++)
        m->x1[j] = two_sum(m->x[j], m->dx[j] + m->carry[j], &m->carry1[j]);
    if (m->p->project)
        sga_copy(m->work, m->x1, m->p->n);
    if (!ode_settle(m, m->t1, m->x1, ode_settle_most(m, m->step.doubt), &residual))
        return MANIFOLD_REFUSED;
    for (int j = 0; m->p->project && j < m->p->n; j++)
        if (m->work[j] != m->x1[j])
            m->carry1[j] = 0;
    if (m->step.f_end && !m->beside && (!m->p->project || (m->method->series && m->moved <= 0.01)))
        sga_copy(m->f1, m->step.f_end, m->p->n);
    else if (!ode_eval(&m->field, m->t1, m->x1, m->f1))
        return FIELD_REFUSED;
    m->pending_residual = residual;
    enum ode_refusal cause = ode_kinks_step(m);
    if (cause == STEP_TAKEN && m->bands)
        cause = ode_bands_step(m);
    if (cause != STEP_TAKEN)
        return cause;
    if (m->p->along && !ode_goes_on_along(m))
        return FIELD_REFUSED;
    cause = ode_sample(m, through);
    return cause == STEP_TAKEN ? ode_watch_step(m, through) : cause;
}

static void swap(double **a, double **b)
{
    double *c = *a;
    *a = *b;
    *b = c;
}

double ode_errors(const struct ode_march *m)
{
    return m->errors + (m->method->implicit ? fmax(1, m->step.error) : m->step.error);
}

double ode_erred(const struct ode_march *m) { return m->erred + (m->method->implicit ? fmax(ITERATED, m->step.error) : m->step.error); }

static void commit(struct ode_march *m, double h, int through)
{
    struct ode_stats *s = &m->res->stats;
    assert(m->step.h * m->direction > 0);       /* it may be shorter than asked for, and does not turn round */
    s->steps++;
    m->errors = ode_errors(m);
    m->erred = ode_erred(m);
    s->smallest_step = s->smallest_step > 0 ? sga_smaller(s->smallest_step, h) : h;
    s->largest_step = sga_larger(s->largest_step, h);
    s->implicit_steps += m->method->implicit;
    m->choice.series_steps += m->method->series;
    bool stiff = m->method->stiff && m->method->stiff(m->state, &m->step);
    s->stiff_steps += stiff;
    m->choice.stiff = stiff ? m->choice.stiff + 1 : m->choice.stiff > 0 ? m->choice.stiff - 1 : 0;
    if (through > m->next)
        m->res->max_residual = fmax(m->res->max_residual, m->pending_residual);
    ode_companion_step(m->companion, m, through);
    m->next = through;
    m->last_times[0] = m->last_times[1];
    m->last_times[1] = m->t;
    m->t = m->t1;
    m->t_low = m->t1_low;
    swap(&m->last, &m->x);
    swap(&m->x, &m->x1);
    swap(&m->carry, &m->carry1);
    swap(&m->f, &m->f1);
    if (m->p->taken && m->p->taken(m->p->ctx, m->t, m->x)) {
        memset(m->carry, 0, (size_t)m->p->n * sizeof *m->carry);
        if (ode_eval(&m->field, m->t, m->x, m->work))      /* otherwise the next step says so */
            sga_copy(m->f, m->work, m->p->n);
    }
}

/* How much shorter steps must be where samples lie inside; what a look inside has told is
 * forgotten slowly. */
static void learn_dense(struct ode_march *m, double forget)
{
    double ratio = m->step.dense_error > m->step.error
                       ? pow(m->step.error / m->step.dense_error, 1.0 / m->step.error_order) : 1;
    m->dense_ratio = m->dense_checked ? ratio : sga_smaller(ratio, forget * m->dense_ratio);
    m->dense_ratio = sga_larger(m->dense_ratio, 1e-3);
}

/* What the next step is to be multiplied by after a refusal. */
static double after_refusal(struct ode_march *m, enum ode_refusal cause)
{
    m->res->stats.refused++;
    m->control.refused_before = true;
    m->manifold_refused += cause == MANIFOLD_REFUSED;
    assert(cause != NOT_SOLVED || (m->step.retry > 0 && m->step.retry < 1));       /* the next try is shorter */
    if (cause == MANIFOLD_REFUSED && m->manifold_why == ODE_CONSTRAINT_LOST)
        ode_settle_refused(m);
    if (m->p->refused)
        m->p->refused(m->p->ctx);
    if (cause == FIELD_REFUSED) {
        m->field_refused = true;
        m->field_refused_t = m->t;
    }
    if (cause == ERROR_TOO_LARGE && m->dense_checked)
        learn_dense(m, 1);
    if (cause == ERROR_TOO_LARGE)
        return ode_control_refused(&m->control, m->error);
    return cause == NOT_SOLVED ? m->step.retry : 0.5;
}

/* What the next step is to be multiplied by after this one was accepted. */
static double after_step(struct ode_march *m, double taken)
{
    m->control.error_order = m->step.error_order;
    double known = m->step.log_error, factor = 1;
    if (!m->method->series)                  /* which look ahead themselves */
        factor = isnan(known) ? ode_control_accepted(&m->control, m->step.error, taken) : ode_control_quick(&m->control, known, taken);
    learn_dense(m, 1.2);
    return m->method->accepted ? m->method->accepted(m->state, &m->step, factor) : factor;
}

/* Steps that lead nowhere any more may be made in another way; series just behind a place where they end (a root that begins) are of no use. */
static bool otherwise(struct ode_march *m)
{
    if ((m->t == m->start->t || ode_kinks_turned(m)) && ode_without_series(m))
        return true;
    if (!m->method->otherwise || !m->method->otherwise(m->state))
        return false;
    if (m->p->otherwise)
        m->p->otherwise(m->p->ctx);
    return true;
}

/* Steps are cut short for other reasons than their errors. */
static bool is_bounded(const struct ode_march *m)
{
    return m->dense_ratio < 1 || isfinite(m->piece) || (m->level && !m->method->series) || m->kinks || m->bands || m->p->pieces;
}

/* A solution whose companion was lost has to be compared with another one, for which the time that is granted may be too short where both are gone all of the way:
 * then it ends here. */
static bool is_of_use(struct ode_march *m)
{
    const struct sga_budget *all = m->o->budget;
    if (!m->o->keep_rows || !all || !(all->deadline > 0) || !ode_companion_lost(m->companion))
        return true;
    double now = sga_now(), part = fabs(m->t - m->start->t) / fabs(m->stop - m->start->t), both = (now - m->begun) * (2 - part) / part;
    if (both < ENOUGH * (all->deadline - now))
        return true;
    ode_end_at(m, ODE_TIME_LIMIT, "");
    return false;
}

static void go(struct ode_march *m, bool accompanied)
{
    double h;
    bool goes_on = begin(m, &h);
    m->companion = accompanied ? ode_companion_begin(m) : NULL;
    if (!goes_on)
        return;
    ode_control_begin(&m->control, m->method->error_order);
    m->budget_looked = m->begun = sga_now();
    m->look_t = m->pile_t = m->t;
    m->look_progress = INFINITY;
    while (ode_may_go_on(m)) {
        double aim, taken = cut(m, h, &aim);
        int through = m->next;
        enum ode_refusal cause = attempt(m, &taken, aim, &through);
        if (cause == STEP_TAKEN) {
            commit(m, taken, through);
            ode_bands_pass(m);
            if (m->stopped) {
                ode_end_event(m);
                return;
            }
            if (m->next == m->start->count || !pass_break(m) || !ode_kinks_pass(m, taken))
                return;
            if (!is_of_use(m))
                return;
            double next = taken * after_step(m, taken);
            /* a step cut short says little against the size that was thought right */
            h = ode_choose(m, taken < 0.9 * h && is_bounded(m) ? fmax(h, next) : next);
            if (m->late)       /* a step that was cut short to a sample may be of a few roundings of time only */
                h = fmax(h, 2 * smallest_step(m));
            cause = ERROR_TOO_LARGE;   /* what it is if h is too small now */
        } else if (cause == ENDED || ((cause == FIELD_REFUSED || cause == NOT_SOLVED || cause == MANIFOLD_REFUSED) && ode_is_over(m))) {
            return;
        } else if (cause == STEP_CUT) {
            m->res->stats.refused++;
        } else if (cause == FIELD_REFUSED && ode_without_series(m)) {
            double last = fabs(m->t - m->last_times[1]);     /* what was tried is a bound, perhaps far beyond the domain */
            h = last > 0 ? fmin(taken, last) : taken;
        } else if (ode_kinks_natural(m, cause, taken)) {
            h = taken;
        } else {
            ode_kinks_held(m);
            h = taken * after_refusal(m, cause);
        }
        if (h < smallest_step(m) && otherwise(m))
            h = sga_larger(fabs(m->t - m->last_times[1]), 2 * smallest_step(m));
        if (h < smallest_step(m)) {
            ode_end_refused(m, cause == NOT_SOLVED ? ERROR_TOO_LARGE : cause);
            return;
        }
    }
}

void ode_march(const struct ode_run *run, struct ode_result *res)
{
    const struct ode_start *start = run->start;
    const struct ode_method *method = ode_method_find(run->o.method, run->o.rtol);
    *res = (struct ode_result){.n = run->p->n, .max_error = -1, .worst = -1, .rtol = run->o.rtol, .atol = run->o.atol,
                               .method = method->name, .solutions = 1};
    res->samples = sga_malloc(((size_t)start->count * (size_t)run->p->n + 1) * sizeof(double));
    res->inside = sga_calloc((size_t)start->count + 1, sizeof(double));
    struct ode_march m = {
        .p = run->p, .start = start, .o = &run->o, .unit = run->unit, .level = run->level, .beside = run->beside, .series = run->series,
        .res = res, .method = method, .field = {run->p, &res->stats, ODE_LEFT_DOMAIN, run->beside, run->noise},
        .manifold_why = ODE_CONSTRAINT_LOST, .t = start->t, .stop = start->times[start->count - 1],
    };
    m.dense_ratio = 1;
    m.direction = m.stop < m.t ? -1 : 1;
    m.last_times[0] = m.last_times[1] = m.t;
    res->end = (struct ode_end){ .reason = ODE_NONE, .t = m.stop, .variable = -1 };
    march_alloc(&m);
    ode_watch_begin(&m);
    ode_kinks_begin(&m);
    ode_bands_begin(&m);
    ode_choice_begin(&m);
    go(&m, run->accompanied);
    res->apart = ode_companion_end(m.companion);
    assert(ode_march_sane(&m));
    if (res->end.reason != ODE_NONE && res->end.reason != ODE_EVENT)
        ode_within_budget(&m); /* what failed may have been stopped (watch.h) */
    if (run->p->enter)
        run->p->enter(run->p->ctx, NAN, NAN);
    ode_kinks_end(&m);
    ode_bands_end(&m);
    res->count = m.next;
    assert(res->end.reason != ODE_NONE || res->count == start->count);       /* no end without a reason */
    ode_choice_end(&m);
    ode_watch_end(&m);
    free(m.memory);
}
