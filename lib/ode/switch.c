/* The choice between the explicit and the implicit method, while marching.
 *
 * It is made by trying. Where stability has set the size of a number of explicit steps
 * (Hairer, Wanner, Solving Ordinary Differential Equations II, IV.2), and at growing
 * intervals anyway because that test sees real eigenvalues only, implicit steps are tried
 * from the present point; the method that gets farther for its work goes on. Work is
 * counted in evaluations of the field and never measured, so that runs repeat exactly.
 * Fine tolerances hand
 * explicit steps on to Taylor series, and take them back where there are none. The way back: where the largest eigenvalue of the last Jacobian would allow explicit
 * steps that cost less. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "companion.h"
#include "lin_sparse.h"
#include "march.h"
#include "mem.h"
#include "radau.h"

#define STIFF_ENOUGH 6        /* steps set by stability before the implicit method is tried */
#define TRY_EARLY 24           /* steps after which it is tried anyway where so many more are to come */
#define TRY_MANY 150.0
#define TRY_AFTER 300          /* where they are not, or it was no better: after so many, then twice, ... */
#define BACK_AFTER 25          /* implicit steps between looks at the way back */
#define ON_TRIAL 96            /* steps set by stability after which implicit steps are made although one try of them did not look longer */
#define ON_TRIAL_REST 1000.0   /* where so many explicit steps are left; */
#define SOON_ON_TRIAL 12       /* after so many where the trial costs this part of what is left explicitly */
#define TRIAL_PART 0.05
#define STEADY 0.01            /* of the mean of all steps: where steps pile up at a singularity, whose fast parts are no stiffness, none is tried soon */
#define GAIN 1.5               /* by which another method must be better */
#define FINE_RTOL 1.1e-10      /* from here on Taylor series go farther for their work: measured over the references */
#define BESIDE 10.0            /* of what a problem says of itself, where the error comes with series (companion.h), and for others by another solution */
#define SERIES_AFTER 3         /* steps before they are tried; a stiff start shows in these */
#define TRIALS 5
#define POWER_STEPS 12
#define EXPLICIT_REACH 0.65    /* of the stability limit: explicit steps of this size are stable in all directions */

bool ode_takes_series(const struct ode_problem *p, const struct ode_options *o)
{
    if (!p->taylor || !ode_method_is_auto(o->method))
        return false;
    if (!(p->taylor_rtol > 0))
        return o->rtol <= FINE_RTOL;
    return o->rtol <= p->taylor_rtol * (o->estimate_global_error && ode_companion_goes_with(p) ? BESIDE : 1);
}

void ode_choice_begin(struct ode_march *m)
{
    struct ode_choice *c = &m->choice;
    *c = (struct ode_choice){.free = ode_method_is_auto(m->o->method), .enough = STIFF_ENOUGH, .try_at = TRY_EARLY,
                             .explicit = m->method->implicit || m->method->series ? ode_method_find(NULL, m->o->rtol) : m->method};
    if (c->free && m->p->implicit) {
        m->method = &ode_radau;
        c->free = false;
    }
    if (c->free && m->series)
        m->method = &ode_taylor;
    m->state = m->method->alloc(m->p);
    *(m->method->implicit ? &c->implicit_state : m->method->series ? &c->series_state : &c->explicit_state) = m->state;
    c->series_wait = SERIES_AFTER;
    c->series_at = c->free && m->series ? SERIES_AFTER : -1;
}

void ode_choice_end(struct ode_march *m)
{
    struct ode_choice *c = &m->choice;
    const struct ode_stats *s = &m->res->stats;
    if (c->implicit_state)
        ode_radau.free(c->implicit_state);
    if (c->explicit_state)
        c->explicit->free(c->explicit_state);
    if (c->series_state)
        ode_taylor.free(c->series_state);
    assert(s->steps >= s->implicit_steps + c->series_steps);
    int which = (s->steps > s->implicit_steps + c->series_steps) + 2 * (c->series_steps > 0) + 4 * (s->implicit_steps > 0);
    static const char *const name[] = { NULL, NULL, "taylor", "dop853, taylor", "radau", NULL, "taylor, radau",
                                        "dop853, taylor, radau" };
    if (which)
        m->res->method = which == 1 ? c->explicit->name : which == 5 ? c->explicit->and_radau : name[which];
}

static void forget_explicit(const struct ode_choice *c)
{
    if (c->explicit->forget)
        c->explicit->forget(c->explicit_state);
}

/* Explicit steps at a fine tolerance: by Taylor series from now on, if there are any here. */
static double try_series(struct ode_march *m, double h)
{
    struct ode_choice *c = &m->choice;
    c->series_wait *= 2;
    c->series_at = m->res->stats.steps + c->series_wait;
    if (!c->series_state)
        c->series_state = ode_taylor.alloc(m->p);
    ode_prepare_step(m, fmin(2 * h, fabs(m->stop - m->t)) * m->direction);
    enum ode_reason why = m->field.why;
    bool solved = ode_taylor.attempt(c->series_state, &m->field, &m->step) == ODE_STEPPED && m->step.error <= 1;
    m->field.why = why;
    if (!solved)
        return h;
    m->method = &ode_taylor;
    m->state = c->series_state;
    m->dense_ratio = 1;
    ode_control_begin(&m->control, ode_taylor.error_order);
    c->try_at = m->res->stats.steps + TRY_EARLY;
    c->h = 0;
    return fabs(m->step.h);
}

bool ode_without_series(struct ode_march *m)
{
    struct ode_choice *c = &m->choice;
    if (!m->method->series)
        return false;
    if (!c->explicit_state)
        c->explicit_state = c->explicit->alloc(m->p);
    m->method = c->explicit;
    m->state = c->explicit_state;
    c->series_at = m->res->stats.steps + c->series_wait;
    forget_explicit(c);
    ode_control_begin(&m->control, c->explicit->error_order);
    return true;
}

static double size_from(const struct ode_step *s, double h)
{
    return 0.9 * h * fmin(6, pow(fmax(s->error, 1e-10), -1.0 / s->error_order));
}

/* The size that implicit steps would have here, found in a few tries from h on; 0 where
 * none succeeds. */
static double implicit_size(struct ode_march *m, double h)
{
    double found = 0, rest = fabs(ode_goal(m) - m->t);
    h *= 6;
    for (int k = 0; k < TRIALS && h > 0; k++) {
        h = fmin(h, rest);
        ode_prepare_step(m, h * m->direction);
        bool solved = ode_radau.attempt(m->choice.implicit_state, &m->field, &m->step) == ODE_STEPPED;
        if (solved && m->step.error <= 1) {
            double next = size_from(&m->step, h);
            m->choice.cost = m->step.cost;
            found = fmin(next, rest);
            if (next < 3 * h || h >= rest)
                return found;
            h = next;
        } else if (found > 0) {
            return found;
        } else {
            h *= solved ? fmin(0.5, pow(m->step.error, -1.0 / m->step.error_order)) : 0.25;
        }
    }
    return found;
}

/* Explicit steps at the limit of stability leave fast parts that tremble at the tolerance. An implicit step of any
 * size sees these in its error, however far it could go once they are damped: only further steps can tell. Where
 * they are not longer, the way back is found after BACK_AFTER of them, and twice as many explicit ones pass before
 * the next trial. */
static bool on_trial(const struct ode_march *m, double there)
{
    const struct ode_choice *c = &m->choice;
    double left = fabs(ode_goal(m) - m->t) / c->h;       /* explicit steps */
    double mean = fabs(m->t - m->start->t) / fmax(1, (double)m->res->stats.steps);
    bool soon = c->enough > SOON_ON_TRIAL && c->h > STEADY * mean && BACK_AFTER * c->cost < TRIAL_PART * left * c->explicit->cost;
    return !m->method->series && there >= c->h && (soon || (c->enough > ON_TRIAL && left > ON_TRIAL_REST));
}

/* Explicit steps so far: is the implicit method better? */
static double try_implicit(struct ode_march *m, double h)
{
    struct ode_choice *c = &m->choice;
    long steps = m->res->stats.steps;
    double explicit_cost = m->method->series ? m->step.cost : c->explicit->cost;
    double own = m->method->series ? fabs(m->step.h) : h;       /* a series' h is an upper bound only */
    bool stiff = c->stiff >= c->enough;
    c->h = c->h > 0 ? 0.9 * c->h + 0.1 * own : own;
    if (!stiff && steps < c->try_at)
        return h;
    double usual = own < STEADY * c->h ? own : c->h;       /* far shorter than the ones before: they are what is to come */
    bool postpone = !stiff && steps < TRY_AFTER && fabs(m->stop - m->t) < TRY_MANY * usual;
    if (stiff)
        c->enough *= 2;
    else
        c->try_at = postpone ? TRY_AFTER : c->since ? c->since + 2 * (steps - c->since) : steps < TRY_AFTER ? 4 * steps : 2 * steps;
    if (postpone)
        return h;
    c->stiff = 0;
    if (!c->implicit_state)
        c->implicit_state = ode_radau.alloc(m->p);
    ode_radau.forget(c->implicit_state);
    enum ode_reason why = m->field.why;
    double there = implicit_size(m, own);
    m->field.why = why;
    ode_radau.forget(c->implicit_state);
    bool better = there / c->cost > GAIN * c->h / explicit_cost;
    if (!better && !(stiff && on_trial(m, there)))
        return h;
    m->method = &ode_radau;
    m->state = c->implicit_state;
    ode_control_begin(&m->control, ode_radau.error_order);
    if (better)
        c->enough = STIFF_ENOUGH;
    c->back_at = steps + BACK_AFTER;
    return better ? there / 3 : fmin(there / 3, c->h);       /* on trial it has to find its size itself */
}

/* The largest |eigenvalue| of the last Jacobian, by a power iteration: the mean growth of
 * the last steps, for a complex pair too. */
static double spectral_radius(struct ode_march *m, const struct radau *r)
{
    struct lin_sparse *J = r->partials.pattern;
    int n = m->p->n, counted = 0;
    double *v = m->work, *w = m->work + n, growth = 0;
    memcpy(J->val, r->jac, (size_t)J->ptr[n] * sizeof *J->val);
    for (int j = 0; j < n; j++)
        v[j] = m->unit[j] * (1 + 0.5 * sin(1.0 + 2.3 * j));
    for (int k = 0; k < POWER_STEPS; k++) {
        double before = 0, after = 0;
        lin_sparse_times(J, v, w);
        for (int j = 0; j < n; j++) {
            before += (v[j] / m->unit[j]) * (v[j] / m->unit[j]);
            after += (w[j] / m->unit[j]) * (w[j] / m->unit[j]);
        }
        if (!(after > 0) || !isfinite(after))
            return after > 0 ? INFINITY : 0;
        for (int j = 0; j < n; j++)
            v[j] = w[j] / sqrt(after);
        if (k >= POWER_STEPS / 2) {
            growth += log(after / before) / 2;
            counted++;
        }
    }
    return exp(growth / counted);
}

/* Implicit steps so far: would explicit ones be better? */
static double try_explicit(struct ode_march *m, double h)
{
    struct ode_choice *c = &m->choice;
    c->cost = 0.8 * c->cost + 0.2 * m->step.cost;
    if (m->res->stats.steps < c->back_at)
        return h;
    c->back_at = m->res->stats.steps + BACK_AFTER;
    double radius = spectral_radius(m, c->implicit_state), there = fmin(EXPLICIT_REACH * c->explicit->stable / fmax(radius, 1e-300), h);
    if (!(there / c->explicit->cost > GAIN * h / c->cost))
        return h;
    if (!c->explicit_state)
        c->explicit_state = c->explicit->alloc(m->p);
    forget_explicit(c);
    ode_prepare_step(m, there * m->direction);
    if (c->explicit->attempt(c->explicit_state, &m->field, &m->step) != ODE_STEPPED)
        return h;
    there = fmin(there, size_from(&m->step, there));
    if (!(there / c->explicit->cost > GAIN * h / c->cost))
        return h;
    m->method = c->explicit;
    m->state = c->explicit_state;
    forget_explicit(c);
    m->dense_ratio = 1;
    ode_control_begin(&m->control, c->explicit->error_order);
    c->h = there;
    c->stiff = 0;
    c->since = m->res->stats.steps;
    c->try_at = c->since + TRY_AFTER;
    if (c->series_at >= 0)
        c->series_at = m->res->stats.steps + c->series_wait;
    return there;
}

double ode_choose(struct ode_march *m, double h)
{
    const struct ode_choice *c = &m->choice;
    if (m->p->n == 0)
        return h;
    if (c->series_at >= 0 && m->res->stats.steps >= c->series_at && !m->method->implicit && !m->method->series && (c->stiff == 0 || !c->free))
        return try_series(m, h);
    if (!c->free)
        return h;
    return m->method->implicit ? try_explicit(m, h) : try_implicit(m, h);
}
