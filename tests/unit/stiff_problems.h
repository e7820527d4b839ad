/* Stiff problems for the tests of the integrator, with published end values: F. Mazzia and
 * C. Magherini, Test Set for Initial Value Problem Solvers, release 2.4 (2008); Hairer,
 * Wanner, Solving Ordinary Differential Equations II, IV.10. */
#ifndef TESTS_UNIT_STIFF_PROBLEMS_H
#define TESTS_UNIT_STIFF_PROBLEMS_H

#include <math.h>
#include "ode.h"

static bool robertson(void *c, double t, const double *x, double *dx)
{
    (void)c;
    (void)t;
    double a = 0.04 * x[0], b = 1e4 * x[1] * x[2], q = 3e7 * x[1] * x[1];
    dx[0] = -a + b;
    dx[1] = a - b - q;
    dx[2] = q;
    return true;
}

static bool van_der_pol(void *c, double t, const double *x, double *dx)
{
    (void)c;
    (void)t;
    dx[0] = x[1];
    dx[1] = ((1 - x[0] * x[0]) * x[1] - x[0]) / 1e-6;
    return true;
}

static bool hires(void *c, double t, const double *y, double *d)
{
    (void)c;
    (void)t;
    d[0] = -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007;
    d[1] = 1.71 * y[0] - 8.75 * y[1];
    d[2] = -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4];
    d[3] = 8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3];
    d[4] = -1.745 * y[4] + 0.43 * (y[5] + y[6]);
    d[5] = -280 * y[5] * y[7] + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6];
    d[6] = 280 * y[5] * y[7] - 1.81 * y[6];
    d[7] = -d[6];
    return true;
}

static bool orego(void *c, double t, const double *y, double *d)
{
    (void)c;
    (void)t;
    d[0] = 77.27 * (y[1] + y[0] * (1 - 8.375e-6 * y[0] - y[1]));
    d[1] = (y[2] - (1 + y[0]) * y[1]) / 77.27;
    d[2] = 0.161 * (y[0] - y[2]);
    return true;
}

/* Prothero-Robinson: x' = -1e6 (x - cos t) - sin t, x = cos t */
static bool prothero(void *c, double t, const double *x, double *dx)
{
    (void)c;
    dx[0] = -1e6 * (x[0] - cos(t)) - sin(t);
    return true;
}

/* A linear system whose eigenvalues are -1000 +- 1000 i and -1 (Lambert): closed form. */
static bool rotating(void *c, double t, const double *x, double *dx)
{
    (void)c;
    double u = x[0] - cos(t), v = x[1] - sin(t);
    dx[0] = -1000 * u + 1000 * v - sin(t);
    dx[1] = -1000 * u - 1000 * v + cos(t);
    dx[2] = -x[2] + u;
    return true;
}

static const struct stiff_problem {
    const char *name;
    int n;
    bool (*rhs)(void *, double, const double *, double *);
    double x[8], stop, atol;      /* atol over rtol */
    double end[8];                /* known to 1e-12 or so */
} stiff_problems[] = {
    {"robertson", 3, robertson, {1, 0, 0}, 1e11, 1e-8,
     {0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050}},
    {"van der pol", 2, van_der_pol, {2, 0}, 2, 1, {1.706167732170483, -0.8928097010247975}},
    {"hires", 8, hires, {1, 0, 0, 0, 0, 0, 0, 0.0057}, 321.8122, 1e-3,
     {0.7371312573325668e-3, 0.1442485726316185e-3, 0.5888729740967575e-4, 0.1175651343283149e-2, 0.2386356198831331e-2,
      0.6238968252742796e-2, 0.2849998395185769e-2, 0.2850001604814231e-2}},
    {"orego", 3, orego, {1, 2, 3}, 360, 1e-3, {1.000814870318523, 1228.178521549917, 132.0554942846706}},
    {"prothero", 1, prothero, {1}, 10, 1, {-0.83907152907645245226}},
    {"rotating", 3, rotating, {2, 0, 1}, 3, 1, {-0.98999249660044545727, 0.14112000805986722210, 0.04981196188958866}},
};
enum { STIFF_PROBLEMS = sizeof stiff_problems / sizeof *stiff_problems };

#endif
