/* Keeping points on the manifold. */
#include <assert.h>
#include <float.h>
#include <math.h>

#include "larger.h"
#include "march.h"

/* A correction of up to this part of the allowed error spoils nothing, however small the
 * error estimate of the step happens to be. */
#define HARMLESS 0.01
/* A correction that is still this part of what it was after a step of half the size, so many times, is a rounding; up to this part of
 * the allowed error it is put up with. */
#define SAME 0.7
#define SURE 4
#define GRAIN_MOST 0.25

static void set_scale(struct ode_march *m, const double *x)
{
    for (int j = 0; j < m->p->n; j++)
        m->scale[j] = ode_allowed(m->o->rtol, m->o->atol, m->unit[j], x[j], x[j]);
}

/* Root mean square of one rounding of x, and of time, in units of the allowed error. */
static double rounding(const struct ode_march *m, const double *x)
{
    double sum = 0;
    for (int j = 0; j < m->p->n; j++) {
        double a = DBL_EPSILON * (fabs(x[j]) + fabs(m->t * m->f[j])) / ode_allowed(m->o->rtol, m->o->atol, m->unit[j], x[j], x[j]);
        sum += a * a;
    }
    return m->p->n ? sqrt(sum / m->p->n) : 0;
}

double ode_settle_most(const struct ode_march *m, double error)
{
    if (!m->p->project)
        return INFINITY;
    double least = (m->p->implicit || m->p->equations) && m->method->implicit ? 1 : HARMLESS;      /* stages on the equations are solved to a part of the error allowed */
    return sga_larger(10 * error, sga_larger(least, m->grain.allowed));
}

/* Where constraints nearly depend on each other their roundings move points far; that does not shrink with the steps, as errors do. */
void ode_settle_refused(struct ode_march *m)
{
    struct ode_grain *g = &m->grain;
    bool still = m->moved > SAME * g->moved;
    g->still = still ? g->still + 1 : 0;
    g->same = still && m->moved <= GRAIN_MOST ? g->same + 1 : 0;
    g->moved = m->moved;
    if (g->same >= SURE)
        g->allowed = 2 * m->moved;
}

bool ode_settle_trembles(const struct ode_march *m) { return m->grain.still >= SURE; }

bool ode_settle(struct ode_march *m, double t, double *x, double most, double *residual)
{
    const struct ode_problem *p = m->p;
    *residual = 0;
    if (!p->project) {
        if (p->residual)
            *residual = p->residual(p->ctx, t, x);
        return true;
    }
    double moved = 0;
    set_scale(m, x);
    m->res->stats.projections++;
    if (!p->project(p->ctx, t, x, m->scale, &moved, residual)) {
        m->manifold_why = p->why ? p->why(p->ctx) : ODE_CONSTRAINT_LOST;
        return false;
    }
    assert(moved >= 0 && *residual >= 0);
    m->manifold_why = ODE_CONSTRAINT_LOST;
    m->moved = moved;
    return moved <= most || moved <= most + 100 * rounding(m, x);
}
