/* Projection onto xi(t, x) = 0 from the functions and their Jacobian: what fills
 * ode_problem.project for most callers. Gauss-Newton steps of least weighted norm by
 * lin_kkt; dense least-norm steps where the rows are dependent and the problem is small. */
#ifndef SGA_ODE_MANIFOLD_H
#define SGA_ODE_MANIFOLD_H

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
struct ode_manifold *ode_manifold_new(const struct ode_constraints *xi);
void ode_manifold_free(struct ode_manifold *m);

/* Moves x onto the manifold at time t; the contract of ode_problem.project with m in
 * place of ctx. Normally one Newton step, after which the residual is at rounding level:
 * |xi_i| below a few roundings of sum_j |J_ij| |x_j|, or as small as further steps make
 * it while below 1e-9 of that sum. At most 50 steps (starts may be far). */
bool ode_manifold_project(struct ode_manifold *m, double t, double *x, const double *scale,
                          double *moved, double *residual);
/* The largest |xi_i|; INFINITY where they are not defined. */
double ode_manifold_residual(struct ode_manifold *m, double t, const double *x);
/* Why the last projection failed: LEFT_DOMAIN (xi not defined), SINGULAR (dependent rows
 * and no way on) or CONSTRAINT_LOST (no convergence). */
enum ode_reason ode_manifold_why(const struct ode_manifold *m);

/* The nearest point: x (in: a guess; out: on the manifold) made to minimise
 * sum_j ((x_j - target_j)/scale_j)^2 over the manifold near the guess, by steps of
 * lin_kkt towards the target, each projected and cut until the distance falls. Linear
 * convergence, fast where the target is close against the manifold's curvature; a local
 * minimum. `tolerance`: stop when a step is below it in units of scale (root mean
 * square). Where rows are dependent (held columns, say) see ode_manifold_project.
 * False as there; also after 200 steps. */
bool ode_manifold_nearest(struct ode_manifold *m, double t, const double *target,
                          const double *scale, double tolerance, double *x);

#endif
