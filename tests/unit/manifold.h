/* A projection for the tests of the integrator: Gauss-Newton steps of least weighted norm by
 * lin_kkt, independent of the one that trajectories use. */
#ifndef TESTS_UNIT_MANIFOLD_H
#define TESTS_UNIT_MANIFOLD_H

#include "lin_sparse.h"
#include "ode.h"

struct ode_constraints {
    int c, n;
    void *ctx;
    const struct lin_sparse *pattern;  /* of d xi / d x, c x n; copied */
    const bool *held;                  /* n: not to be moved; copied; NULL: none */
    /* xi (c), and where J is not NULL the Jacobian's values in the pattern's order, at
     * (t, x). False: not defined there. */
    bool (*eval)(void *ctx, double t, const double *x, double *xi, double *J);
};

struct ode_manifold;
static struct ode_manifold *ode_manifold_new(const struct ode_constraints *xi);
static void ode_manifold_free(struct ode_manifold *m);

/* Moves x onto the manifold at time t; the contract of ode_problem.project with m in
 * place of ctx. Normally one Newton step, after which the residual is at rounding level:
 * |xi_i| below a few roundings of sum_j |J_ij| |x_j|, or as small as further steps make
 * it while below 1e-9 of that sum. At most 50 steps (starts may be far). */
static bool ode_manifold_project(struct ode_manifold *m, double t, double *x, const double *scale,
                          double *moved, double *residual);
/* The largest |xi_i|; INFINITY where they are not defined. */
static double ode_manifold_residual(struct ode_manifold *m, double t, const double *x);
/* Why the last projection failed: LEFT_DOMAIN (xi not defined), SINGULAR (dependent rows
 * and no way on) or CONSTRAINT_LOST (no convergence). */
static enum ode_reason ode_manifold_why(const struct ode_manifold *m);

/* The nearest point: x (in: a guess; out: on the manifold) made to minimise
 * sum_j ((x_j - target_j)/scale_j)^2 over the manifold near the guess, by steps of
 * lin_kkt towards the target, each projected and cut until the distance falls. Linear
 * convergence, fast where the target is close against the manifold's curvature; a local
 * minimum. `tolerance`: stop when a step is below it in units of scale (root mean
 * square). Where rows are dependent (held columns, say) see ode_manifold_project.
 * False as there; also after 200 steps. */
static bool ode_manifold_nearest(struct ode_manifold *m, double t, const double *target,
                          const double *scale, double tolerance, double *x);

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lin_dense.h"
#include "lin_kkt.h"
#include "mem.h"

#define MOST_STEPS 50
#define MOST_STEPS_NEAREST 200
#define ROUNDINGS 8            /* of the terms of a row: a residual of this size is 0 */
#define STALLED_MOST 1e-9      /* a residual that no longer falls may be this large */
#define DENSE_MOST 250000      /* c * n up to which dependent rows are dealt with */
#define DENSE_RTOL 1e-11

struct ode_manifold {
    struct ode_constraints xi;
    struct lin_sparse *J;
    bool *held;
    struct lin_kkt *kkt;
    double *r, *w, *d, *g, *x0;
    enum ode_reason why;
};

static struct ode_manifold *ode_manifold_new(const struct ode_constraints *xi)
{
    struct ode_manifold *m = sga_calloc(1, sizeof *m);
    size_t n = (size_t)xi->n, c = (size_t)xi->c;
    m->xi = *xi;
    m->J = lin_sparse_new(xi->c, xi->n, xi->pattern->ptr, xi->pattern->col);
    m->xi.pattern = m->J;
    if (xi->held) {
        m->held = sga_malloc((n + 1) * sizeof *m->held);
        memcpy(m->held, xi->held, n * sizeof *m->held);
    }
    m->xi.held = m->held;
    m->kkt = lin_kkt_new(m->J);
    m->r = sga_calloc(c + 4 * n + 1, sizeof *m->r);
    m->w = m->r + c;
    m->d = m->w + n;
    m->g = m->d + n;
    m->x0 = m->g + n;
    return m;
}

static void ode_manifold_free(struct ode_manifold *m)
{
    if (!m)
        return;
    lin_kkt_free(m->kkt);
    lin_sparse_free(m->J);
    free(m->held);
    free(m->r);
    free(m);
}

static enum ode_reason ode_manifold_why(const struct ode_manifold *m)
{
    return m->why;
}

static bool give_up(struct ode_manifold *m, enum ode_reason why)
{
    m->why = why;
    return false;
}

/* xi, and J where asked, at x; false: not defined or not finite. */
static bool evaluate(struct ode_manifold *m, double t, const double *x, bool jacobian)
{
    double *J = jacobian ? m->J->val : NULL;
    if (!m->xi.eval(m->xi.ctx, t, x, m->r, J) || !lin_all_finite(m->xi.c, m->r) ||
        (jacobian && !lin_all_finite(m->J->ptr[m->xi.c], J)))
        return give_up(m, ODE_LEFT_DOMAIN);
    return true;
}

/* The largest |xi_i|, and the largest in units of the rounding of its row's terms. */
static double size_of_residual(const struct ode_manifold *m, const double *x, double *roundings)
{
    double most = 0;
    *roundings = 0;
    for (int i = 0; i < m->xi.c; i++) {
        double r = fabs(m->r[i]), terms = DBL_MIN;
        for (int e = m->J->ptr[i]; e < m->J->ptr[i + 1]; e++)
            terms += fabs(m->J->val[e] * x[m->J->col[e]]);
        most = fmax(most, r);
        *roundings = fmax(*roundings, r / (DBL_EPSILON * terms));
    }
    return most;
}

static void set_weights(struct ode_manifold *m, const double *scale)
{
    for (int j = 0; j < m->xi.n; j++)
        m->w[j] = 1 / scale[j];
}

/* d for the residual in m->r, by J as last evaluated; g may be NULL. */
static bool correction(struct ode_manifold *m, const double *g)
{
    if (lin_kkt_factor(m->kkt, m->J->val, m->w, m->held)) {
        lin_kkt_solve(m->kkt, m->r, g, m->d);
    } else {
        struct lin_correction p = {m->J, m->w, m->held, m->r, g};
        if ((double)m->xi.c * m->xi.n > DENSE_MOST ||
            !lin_correction_dense(&p, DENSE_RTOL, m->d, NULL))
            return give_up(m, ODE_SINGULAR);
    }
    return lin_all_finite(m->xi.n, m->d) || give_up(m, ODE_SINGULAR);
}

/* Root mean square of (x - from)/scale. */
static double distance(const struct ode_manifold *m, const double *x, const double *from,
                       const double *scale)
{
    double sum = 0;
    for (int j = 0; j < m->xi.n; j++) {
        double a = (x[j] - from[j]) / scale[j];
        sum += a * a;
    }
    return m->xi.n ? sqrt(sum / m->xi.n) : 0;
}

/* Newton steps. The Jacobian is taken at the first point and at those that turn out not to
 * be the last: the usual projection costs one Jacobian and two residuals. */
static bool newton(struct ode_manifold *m, double t, double *x, double *residual)
{
    double roundings, before = INFINITY;
    for (int step = 0; step <= MOST_STEPS; step++) {
        if (!evaluate(m, t, x, step == 0))
            return false;
        *residual = size_of_residual(m, x, &roundings);
        if (roundings <= ROUNDINGS ||
            (roundings > 0.5 * before && roundings * DBL_EPSILON < STALLED_MOST))
            return true;
        before = roundings;
        if ((step > 0 && !evaluate(m, t, x, true)) || !correction(m, NULL))
            return false;
        for (int j = 0; j < m->xi.n; j++)
            x[j] += m->d[j];
    }
    return give_up(m, ODE_CONSTRAINT_LOST);
}

static bool ode_manifold_project(struct ode_manifold *m, double t, double *x, const double *scale,
                          double *moved, double *residual)
{
    memcpy(m->x0, x, (size_t)m->xi.n * sizeof *x);
    set_weights(m, scale);
    if (!newton(m, t, x, residual))
        return false;
    *moved = distance(m, x, m->x0, scale);
    return true;
}

static double ode_manifold_residual(struct ode_manifold *m, double t, const double *x)
{
    double most = 0;
    if (!evaluate(m, t, x, false))
        return INFINITY;
    for (int i = 0; i < m->xi.c; i++)
        most = fmax(most, fabs(m->r[i]));
    return most;
}

/* A step along d from x, projected, that lowers the distance to the target enough; x is
 * replaced. False: no length does. */
static bool nearer(struct ode_manifold *m, double t, const double *target,
                   const double *scale, double step, double *x)
{
    int n = m->xi.n;
    double before = distance(m, x, target, scale), moved, residual;
    double *y = sga_malloc(2 * ((size_t)n + 1) * sizeof *y), *d = y + n;
    memcpy(d, m->d, (size_t)n * sizeof *d);
    bool found = false;
    for (double s = 1; s > 1e-9 && !found; s /= 2) {
        for (int j = 0; j < n; j++)
            y[j] = x[j] + s * d[j];
        if (!ode_manifold_project(m, t, y, scale, &moved, &residual))
            continue;
        double after = distance(m, y, target, scale);
        found = after * after < before * before - 0.1 * s * step * step;
    }
    if (found)
        memcpy(x, y, (size_t)n * sizeof *x);
    free(y);
    return found;
}

static bool ode_manifold_nearest(struct ode_manifold *m, double t, const double *target,
                          const double *scale, double tolerance, double *x)
{
    double moved, residual;
    if (!ode_manifold_project(m, t, x, scale, &moved, &residual))
        return false;
    for (int turn = 0; turn < MOST_STEPS_NEAREST; turn++) {
        for (int j = 0; j < m->xi.n; j++)
            m->g[j] = target[j] - x[j];
        if (!evaluate(m, t, x, true) || !correction(m, m->g))
            return false;
        double step = 0;
        for (int j = 0; j < m->xi.n; j++)
            step += (m->d[j] / scale[j]) * (m->d[j] / scale[j]);
        step = m->xi.n ? sqrt(step / m->xi.n) : 0;
        if (step <= tolerance)
            return true;
        /* near the end rounding hides what a step gains */
        if (!nearer(m, t, target, scale, step, x))
            return step <= 1e-6 * distance(m, x, target, scale) ||
                   give_up(m, ODE_CONSTRAINT_LOST);
    }
    return give_up(m, ODE_CONSTRAINT_LOST);
}

#endif
