/* Samples: dense output inside a step, each sample projected onto the manifold of its
 * own time, so that samples satisfy the constraints as well as the steps' ends do. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "larger.h"
#include "march.h"

/* The polynomial is of lower order than the step: a sample may be moved further than a
 * step's end, but not out of the error allowed. */
#define SAMPLE_MOST 10.0

/* Signed distance from the present step's end to a time, positive beyond it. */
static double beyond(const struct ode_march *m, double t)
{
    return ((t - m->t1) - m->t1_low) * m->direction;
}

static bool inner_sample(struct ode_march *m, double t, double *row, double *inside)
{
    double residual, theta = fmin(1, ((t - m->t) - m->t_low) / m->step.h);
    assert(theta >= 0);        /* a sample that was passed is delivered; beyond 1 by roundings of time only */
    m->method->dense_at(m->state, &m->step, theta, row);
    *inside = m->step.dense_error * (m->method->series ? pow(theta, m->step.error_order) : 1);
    if (!ode_settle(m, t, row, SAMPLE_MOST, &residual))
        return false;
    m->pending_residual = sga_larger(m->pending_residual, residual);
    return true;
}

bool ode_sample_inside(const struct ode_march *m)
{
    return m->next < m->start->count && beyond(m, m->start->times[m->next]) < 0;
}

/* Samples so near behind the step's end are at it: where a switch turns there, whose time is told to roundings, they have the values before. */
static double at_end(const struct ode_march *m)
{
    return ode_kinks_turn_ahead(m) ? ODE_TOLD * sga_larger(fabs(m->t), fabs(m->t1)) : 0;
}

enum ode_refusal ode_sample(struct ode_march *m, int *through)
{
    size_t n = (size_t)m->p->n;
    bool dense = false;
    double same = at_end(m);
    int k = m->next;
    for (; k < m->start->count; k++) {
        double *row = m->res->samples + (size_t)k * n, t = m->start->times[k];
        double past = beyond(m, t);
        if (past > same)
            break;
        if (past >= 0) {
            memcpy(row, m->x1, n * sizeof *row);   /* settled already */
            m->res->inside[k] = 0;
            continue;
        }
        if (!dense && !m->dense_checked && !m->method->dense_begin(m->state, &m->field, &m->step))
            return FIELD_REFUSED;
        dense = m->dense_checked = true;
        if (!(m->step.dense_error <= 1)) {
            m->error = m->step.dense_error;
            return ERROR_TOO_LARGE;
        }
        if (!inner_sample(m, t, row, m->res->inside + k))
            return MANIFOLD_REFUSED;
    }
    *through = k;
    return STEP_TAKEN;
}
