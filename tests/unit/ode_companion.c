/* Errors followed along a solution's own steps: against known solutions, on a manifold, and where they are not to be followed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "ode.h"

enum { COUNT = 41 };

/* x'' = -x^3 beside its own energy, by which the period depends on the amplitude: errors grow with the square of time. */
static bool quartic(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx;
    (void)t;
    dx[0] = x[1];
    dx[1] = -x[0] * x[0] * x[0];
    return true;
}

/* A point on the unit circle, x' = -y, y' = x, with the radius held; and an error that is a part along and a part across. */
static bool circle(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx;
    (void)t;
    dx[0] = -x[1];
    dx[1] = x[0];
    return true;
}

static bool radius(void *ctx, double t, double *x, const double *scale, double *moved, double *residual)
{
    (void)ctx;
    (void)t;
    double r = hypot(x[0], x[1]);
    *moved = fabs(r - 1) / scale[0];
    *residual = 0;
    x[0] /= r;
    x[1] /= r;
    return true;
}

static bool along(void *ctx, double t, const double *x, const double *scale, double *e)
{
    (void)t;
    (void)scale;
    double off = x[0] * e[0] + x[1] * e[1];
    ++*(int *)ctx;
    e[0] -= off * x[0];
    e[1] -= off * x[1];
    return true;
}

static bool fast(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx;
    dx[0] = -1e4 * (x[0] - cos(t));
    return true;
}

static void height(void *ctx, double t, const double *x, double *g)
{
    (void)ctx;
    (void)t;
    g[0] = x[0] - 0.5;
}

static void times(double stop, double *t)
{
    for (int k = 0; k < COUNT; k++)
        t[k] = stop * k / (COUNT - 1);
}

static struct ode_result run(const struct ode_problem *p, const double *x, double stop, double tol, bool estimate)
{
    double t[COUNT];
    struct ode_start start = { 0, x, COUNT, t };
    struct ode_options o = ode_options_default();
    struct ode_result r;
    times(stop, t);
    o.rtol = o.atol = tol;
    o.estimate_global_error = estimate;
    CHECK(ode_solve(p, &start, &o, &r, NULL) && r.count == COUNT);
    return r;
}

/* Against a solution at 1e-13: nearly all of the late samples hold, and are not a thousand times too large. */
static void test_grows(void)
{
    struct ode_problem p = { .n = 2, .rhs = quartic };
    double x[] = { 1, 0 };
    struct ode_result best = run(&p, x, 60, 1e-13, false);
    int held = 0, all = 0;
    for (double tol = 1e-4; tol > 1e-10; tol *= 0.1) {
        struct ode_result r = run(&p, x, 60, tol, true);
        CHECK(r.solutions == 1 && r.second.steps == 0 && r.second.evaluations > 0);
        CHECK(fmax(r.error[COUNT - 1], r.error[COUNT - 4]) > 2 * r.error[COUNT / 8], "%g %g", r.error[COUNT / 8], r.error[COUNT - 1]);
        for (int k = COUNT / 2; k < COUNT; k++) {
            double e = fmax(fabs(r.samples[2 * k] - best.samples[2 * k]), fabs(r.samples[2 * k + 1] - best.samples[2 * k + 1]));
            CHECK(e <= 1.5 * r.error[k], "%g, %d: %g %g", tol, k, e, r.error[k]);
            held += e <= r.error[k];
            all++;
        }
        CHECK(r.max_error < 1e4 * tol, "%g: %g", tol, r.max_error);
        ode_result_free(&r);
    }
    ode_result_free(&best);
    CHECK(held > 0.95 * all, "%d of %d", held, all);
}

static void test_manifold(void)
{
    int asked = 0;
    struct ode_problem p = { .n = 2, .ctx = &asked, .rhs = circle, .project = radius, .tangent = along };
    double x[] = { 1, 0 }, t[COUNT];
    times(30, t);
    struct ode_result r = run(&p, x, 30, 1e-7, true);
    CHECK(r.solutions == 1 && asked == r.stats.steps, "%d %ld", asked, r.stats.steps);
    for (int k = 1; k < COUNT; k++)
        CHECK(fmax(fabs(r.samples[2 * k] - cos(t[k])), fabs(r.samples[2 * k + 1] - sin(t[k]))) <= r.error[k]);
    ode_result_free(&r);
    p.tangent = NULL;      /* nobody says what an error on the manifold is */
    r = run(&p, x, 30, 1e-7, true);
    CHECK(r.solutions == 2 && r.second.steps > 0);
    ode_result_free(&r);
}

/* Then two solutions are compared, as well as ever. */
static void test_lost(void)
{
    struct ode_problem stiff = { .n = 1, .rhs = fast }, watched = { .n = 2, .rhs = circle, .events = 1, .event = height };
    double x[] = { 1, 0 }, middle[] = { 15 };
    watched.event_spec = &(struct ode_event){ 0, false };
    struct ode_problem broken = { .n = 2, .rhs = circle, .breaks = middle, .break_count = 1 };
    struct ode_problem *const all[] = { &stiff, &watched, &broken };
    for (int i = 0; i < 3; i++) {
        struct ode_result r = run(all[i], x, 30, 1e-6, true), plain = run(all[i], x, 30, 1e-6, false);
        CHECK(r.solutions == 2 && r.second.steps > 0 && r.worst >= 0 && isfinite(r.worst) && plain.solutions == 1 && !plain.error, "%d", i);
        ode_result_free(&r);
        ode_result_free(&plain);
    }
}

/* x = (cos t, sin t): the terms of order k are those of order 0 turned by k right angles, over k!. */
static bool terms(void *ctx, double t, const double *x, int order, double scale, double *series, double *reach)
{
    (void)ctx;
    (void)t;
    memcpy(series, x, 2 * sizeof *x);
    for (int k = 0; k < order; k++) {
        series[2 * k + 2] = -series[2 * k + 1] * scale / (k + 1);
        series[2 * k + 3] = series[2 * k] * scale / (k + 1);
    }
    *reach = INFINITY;
    return true;
}

/* What is asked for and missed by the first solution is reached by a tighter one, followed too. */
static void test_tighter(void)
{
    struct ode_problem p = { .n = 2, .rhs = circle, .taylor = terms };
    double x[] = { 1, 0 }, t[] = { 10000 };
    struct ode_start start = { 0, x, 1, t };
    struct ode_options o = ode_options_default();
    struct ode_result r;
    o.method = "taylor";
    o.rtol = o.atol = 1e-9;
    o.estimate_global_error = o.refine = true;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.count == 1);
    double miss = fmax(fabs(r.samples[0] - cos(t[0])), fabs(r.samples[1] - sin(t[0])));
    CHECK(r.solutions == 2 && r.rtol < 0.9e-10 && r.worst <= 1 && !r.shortfall, "%d %g %g", r.solutions, r.rtol, r.worst);
    CHECK(miss <= r.error[0], "%g %g", miss, r.error[0]);
    ode_result_free(&r);
}

int main(void)
{
    test_grows();
    test_manifold();
    test_lost();
    test_tighter();
    return CHECK_END();
}
