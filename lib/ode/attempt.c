/* One step: tried, and taken. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "larger.h"
#include "march.h"
#include "mem.h"

/* a + b = sum + *error, exactly (Knuth). */
static double two_sum(double a, double b, double *error)
{
    double s = a + b, v = s - a;
    *error = (a - (s - v)) + (b - v);
    return s;
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

static void place(const void *march, double s, double *x)
{
    const struct ode_march *m = march;
    if (s == 1)
        sga_copy(x, m->x1, m->p->n);
    else
        m->method->dense_at(m->state, &m->step, s, x);
}

/* Explicit steps have looked at many places. */
static bool goes_on_along(struct ode_march *m)
{
    struct ode_path path = { m, m->t, m->step.h, place };
    return !(m->method->series || m->method->implicit) || m->p->along(m->p->ctx, &path) || ode_eval_refused(&m->field);
}

enum ode_refusal ode_attempt(struct ode_march *m, double *h, double aim, int *through)
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
    if (m->p->along && !goes_on_along(m))
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

void ode_commit(struct ode_march *m, double h, int through)
{
    struct ode_stats *s = &m->res->stats;
    assert(m->step.h * m->direction > 0);       /* it may be shorter than asked for, and does not turn round */
    s->steps++;
    s->smallest_step = s->smallest_step > 0 ? sga_smaller(s->smallest_step, h) : h;
    s->largest_step = sga_larger(s->largest_step, h);
    s->implicit_steps += m->method->implicit;
    m->choice.series_steps += m->method->series;
    bool stiff = m->method->stiff && m->method->stiff(m->state, &m->step);
    s->stiff_steps += stiff;
    m->choice.stiff = stiff ? m->choice.stiff + 1 : m->choice.stiff > 0 ? m->choice.stiff - 1 : 0;
    if (through > m->next)
        m->res->max_residual = fmax(m->res->max_residual, m->pending_residual);
    m->next = through;
    m->last_times[0] = m->last_times[1];
    m->last_times[1] = m->t;
    m->t = m->t1;
    m->t_low = m->t1_low;
    swap(&m->x, &m->x1);
    swap(&m->carry, &m->carry1);
    swap(&m->f, &m->f1);
    if (m->p->taken && m->p->taken(m->p->ctx, m->t, m->x)) {
        memset(m->carry, 0, (size_t)m->p->n * sizeof *m->carry);
        if (ode_eval(&m->field, m->t, m->x, m->work))      /* otherwise the next step says so */
            sga_copy(m->f, m->work, m->p->n);
    }
}
