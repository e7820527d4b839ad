/* GSL's odeiv2: one solution of a problem. */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <string.h>

#include "problem.h"

enum { RK8PD, RKF45, RKCK, MSADAMS, MSBDF, BSIMP };
const struct peer gsl_peers[] = {
    {"GSL rk8pd", RK8PD, 8, false}, {"GSL rkf45", RKF45, 5, false}, {"GSL rkck", RKCK, 5, false},
    {"GSL msadams", MSADAMS, 12, false}, {"GSL msbdf", MSBDF, 5, true}, {"GSL bsimp", BSIMP, 0, true}, {0},
};

struct job { const struct problem *p; long evaluations; };

static int field(double t, const double *x, double *dx, void *ctx)
{
    struct job *j = ctx;
    j->p->field(t, x, dx);
    j->evaluations++;
    return GSL_SUCCESS;
}

/* The derivative by time is for bsimp alone: a difference. */
static int slope(double t, const double *x, double *J, double *dt, void *ctx)
{
    struct job *j = ctx;
    double up[16], down[16], d = 6e-6;
    j->p->slope(t, x, J);
    j->p->field(t + d, x, up);
    j->p->field(t - d, x, down);
    for (int i = 0; i < j->p->n; i++)
        dt[i] = (up[i] - down[i]) / (2 * d);
    return GSL_SUCCESS;
}

bool gsl_solve(const struct problem *p, const struct peer *peer, double rtol, struct outcome *o)
{
    const gsl_odeiv2_step_type *types[] = {gsl_odeiv2_step_rk8pd, gsl_odeiv2_step_rkf45, gsl_odeiv2_step_rkck,
                                           gsl_odeiv2_step_msadams, gsl_odeiv2_step_msbdf, gsl_odeiv2_step_bsimp};
    struct job j = {p, 0};
    gsl_odeiv2_system system = {field, slope, (size_t)p->n, &j};
    double x[16], t = 0, begin = cpu_seconds();
    memcpy(x, p->start, (size_t)p->n * sizeof *x);
    gsl_odeiv2_driver *d = gsl_odeiv2_driver_alloc_y_new(&system, types[peer->kind], 1e-6, rtol * p->floor, rtol);
    gsl_odeiv2_driver_set_nmax(d, 1000000);
    bool ok = true;
    for (int k = 0; k < p->samples && ok; k++) {
        ok = gsl_odeiv2_driver_apply(d, &t, p->times[k], x) == GSL_SUCCESS;
        take_sample(p, x, k, o);
    }
    gsl_odeiv2_driver_free(d);
    o->seconds = cpu_seconds() - begin;
    o->evaluations = j.evaluations;
    return ok;
}
