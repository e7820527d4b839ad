/* Solutions on constraint manifolds: the pendulum in Cartesian coordinates for long, with
 * residuals at rounding level in every sample; projection and nearest points. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "lin.h"
#include "manifold.h"
#include "ode.h"

#define G 9.81

/* x, y, u, v; lambda from the second derivative of x^2 + y^2 = 1. */
static bool pendulum(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx;
    (void)t;
    double lambda = (x[2] * x[2] + x[3] * x[3] - G * x[1]) / (x[0] * x[0] + x[1] * x[1]);
    dx[0] = x[2];
    dx[1] = x[3];
    dx[2] = -lambda * x[0];
    dx[3] = -lambda * x[1] - G;
    return isfinite(lambda);
}

static bool circle(void *ctx, double t, const double *x, double *xi, double *J)
{
    (void)ctx;
    (void)t;
    xi[0] = x[0] * x[0] + x[1] * x[1] - 1;
    xi[1] = x[0] * x[2] + x[1] * x[3];
    if (J) {
        double j[] = {2 * x[0], 2 * x[1], x[2], x[3], x[0], x[1]};
        memcpy(J, j, sizeof j);
    }
    return true;
}

static struct lin_sparse *circle_pattern(void)
{
    int ptr[] = {0, 2, 6}, col[] = {0, 1, 0, 1, 2, 3};
    return lin_sparse_new(2, 4, ptr, col);
}

struct setup { struct ode_manifold *m; };

static bool project(void *ctx, double t, double *x, const double *scale, double *moved,
                    double *residual)
{
    return ode_manifold_project(((struct setup *)ctx)->m, t, x, scale, moved, residual);
}
static enum ode_reason why(void *ctx) { return ode_manifold_why(((struct setup *)ctx)->m); }
static double residual(void *ctx, double t, const double *x)
{
    return ode_manifold_residual(((struct setup *)ctx)->m, t, x);
}

static bool angle(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx;
    (void)t;
    dx[0] = x[1];
    dx[1] = -G * sin(x[0]);
    return true;
}

/* The same motion in the angle from the vertical: x = sin a, y = -cos a. */
static void test_against_angle(void)
{
    enum { COUNT = 101 };
    struct lin_sparse *J = circle_pattern();
    struct ode_constraints c = {.c = 2, .n = 4, .pattern = J, .eval = circle};
    struct setup s = {ode_manifold_new(&c)};
    struct ode_problem p = {.n = 4, .rhs = pendulum, .project = project, .ctx = &s, .why = why};
    struct ode_problem q = {.n = 2, .rhs = angle};
    double x[] = {1, 0, 0, 0}, a[] = {M_PI / 2, 0}, t[COUNT];
    for (int k = 0; k < COUNT; k++)
        t[k] = 0.1 * k;
    struct ode_start from = {0, x, COUNT, t}, turn = {0, a, COUNT, t};
    struct ode_options o = ode_options_default();
    o.rtol = o.atol = 1e-10;
    o.estimate_global_error = true;
    struct ode_result r, b;
    CHECK(ode_solve(&p, &from, &o, &r, NULL) && ode_solve(&q, &turn, &o, &b, NULL));
    CHECK(r.count == COUNT && b.count == COUNT && r.start_moved == 0);
    double worst = 0;
    int held = 0;
    for (int k = 0; k < COUNT; k++) {
        double e = fmax(fabs(r.samples[4 * k] - sin(b.samples[2 * k])),
                        fabs(r.samples[4 * k + 1] + cos(b.samples[2 * k])));
        worst = fmax(worst, e);
        held += e <= r.error[k] + b.error[k];
    }
    CHECK(worst < 1e-8, "%g", worst);
    CHECK(held > 0.95 * COUNT, "%d", held);
    CHECK(r.max_residual < 1e-14 && r.start_residual == 0, "%g", r.max_residual);
    CHECK(r.stats.projections > r.stats.steps + COUNT / 2);
    ode_result_free(&r);
    ode_result_free(&b);
    ode_manifold_free(s.m);
    lin_sparse_free(J);
}

/* 250 periods: residuals stay at rounding, the energy at the tolerance's level; without
 * projection both run away. */
static void test_long(void)
{
    enum { COUNT = 1001 };
    struct lin_sparse *J = circle_pattern();
    struct ode_constraints c = {.c = 2, .n = 4, .pattern = J, .eval = circle};
    struct setup s = {ode_manifold_new(&c)};
    double x[] = {0.8, -0.6, 0, 0}, t[COUNT], drift[2];
    for (int k = 0; k < COUNT; k++)
        t[k] = 0.5 * k;
    for (int free_ = 0; free_ < 2; free_++) {
        struct ode_problem p = {.n = 4, .rhs = pendulum, .project = free_ ? NULL : project,
                                .residual = residual, .ctx = &s, .why = why};
        struct ode_start from = {0, x, COUNT, t};
        struct ode_options o = ode_options_default();
        o.rtol = o.atol = 1e-9;
        struct ode_result r;
        CHECK(ode_solve(&p, &from, &o, &r, NULL) && r.count == COUNT, "%s", r.end.detail);
        double energy = 0;
        for (int k = 0; k < r.count; k++) {
            const double *y = r.samples + 4 * k;
            energy = fmax(energy, fabs((y[2] * y[2] + y[3] * y[3]) / 2 + G * (y[1] + 0.6)));
        }
        drift[free_] = r.max_residual;
        if (!free_) {
            CHECK(r.max_residual < 5e-15, "residual %g", r.max_residual);
            CHECK(energy < 1e-5, "energy %g", energy);
        }
        ode_result_free(&r);
    }
    CHECK(drift[1] > 1e-6, "without projection: %g", drift[1]);
    ode_manifold_free(s.m);
    lin_sparse_free(J);
}

/* A time-dependent constraint that pins the solution: x = cos t, y = sin t, and a field
 * with an error: the correction outgrows the step's own error estimate. */
static bool moving(void *ctx, double t, const double *x, double *xi, double *J)
{
    (void)ctx;
    xi[0] = x[0] - cos(t);
    xi[1] = x[0] * x[0] + x[1] * x[1] - 1;
    if (J) {
        double j[] = {1, 2 * x[0], 2 * x[1]};
        memcpy(J, j, sizeof j);
    }
    return true;
}
static bool turning(void *ctx, double t, const double *x, double *dx)
{
    double wrong = *((double *)ctx + 1);
    (void)t;
    dx[0] = -x[1];
    dx[1] = x[0] + wrong;
    return true;
}
struct pinned { struct ode_manifold *m; double wrong; };

static void test_pinned(void)
{
    int ptr[] = {0, 1, 3}, col[] = {0, 0, 1};
    struct lin_sparse *J = lin_sparse_new(2, 2, ptr, col);
    struct ode_constraints c = {.c = 2, .n = 2, .pattern = J, .eval = moving};
    struct pinned s = {ode_manifold_new(&c), 0};
    struct ode_problem p = {.n = 2, .rhs = turning, .project = project, .ctx = &s};
    double t[] = {0.5, 1, 2, 3}, off = 0.3, x[] = {cos(off), sin(off) + 0.01};
    struct ode_start start = {off, x, 4, t};
    struct ode_options o = ode_options_default();
    struct ode_result r;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.count == 4, "%s", r.end.detail);
    CHECK(r.start_moved > 1e5 && r.max_residual < 1e-15, "%g", r.start_moved);
    for (int k = 0; k < r.count; k++)
        CHECK(fabs(r.samples[2 * k + 1] - sin(t[k])) < 1e-14, "%g", r.samples[2 * k + 1] - sin(t[k]));
    ode_result_free(&r);
    s.wrong = 1e-3;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.count == 0 && r.end.reason == ODE_CONSTRAINT_LOST,
          "%s", ode_reason_text(r.end.reason));
    ode_result_free(&r);
    ode_manifold_free(s.m);
    lin_sparse_free(J);
}

/* x^2 = 1 - t: the constraint set is empty beyond t = 1. */
static bool vanishing(void *ctx, double t, const double *x, double *xi, double *J)
{
    (void)ctx;
    xi[0] = x[0] * x[0] - (1 - t);
    if (J)
        J[0] = 2 * x[0];
    return true;
}
static bool follow(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx;
    (void)t;
    dx[0] = -1 / (2 * x[0]);
    return x[0] != 0;
}

static void test_vanishing(void)
{
    int ptr[] = {0, 1}, col[] = {0};
    struct lin_sparse *J = lin_sparse_new(1, 1, ptr, col);
    struct ode_constraints c = {.c = 1, .n = 1, .pattern = J, .eval = vanishing};
    struct setup s = {ode_manifold_new(&c)};
    struct ode_problem p = {.n = 1, .rhs = follow, .project = project, .ctx = &s, .why = why};
    double t[] = {0.5, 0.99, 1.5}, x[] = {1};
    struct ode_start start = {0, x, 3, t};
    struct ode_options o = ode_options_default();
    struct ode_result r;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.count == 2 && r.end.reason != ODE_NONE);
    CHECK(fabs(r.end.t - 1) < 1e-9, "%s at 1 %+g", ode_reason_text(r.end.reason), r.end.t - 1);
    ode_result_free(&r);
    ode_manifold_free(s.m);
    lin_sparse_free(J);
}

/* Nearest points of the unit sphere, an ellipse and a plane, with weights and held. */
static bool ellipse(void *ctx, double t, const double *x, double *xi, double *J)
{
    (void)ctx;
    (void)t;
    xi[0] = x[0] * x[0] + 4 * x[1] * x[1] - 4;
    if (J) {
        J[0] = 2 * x[0];
        J[1] = 8 * x[1];
    }
    return true;
}

static void test_nearest(void)
{
    int ptr[] = {0, 2}, col[] = {0, 1};
    struct lin_sparse *J = lin_sparse_new(1, 2, ptr, col);
    struct ode_constraints c = {.c = 1, .n = 2, .pattern = J, .eval = ellipse};
    struct ode_manifold *m = ode_manifold_new(&c);
    for (int k = 0; k < 40; k++) {
        double far = k % 4 ? 0.3 * (k % 4) : 20;
        double target[] = {2 * cos(k) * (1 + far), sin(k) * (1 + far)};
        double scale[] = {1, k % 3 ? 1 : 2}, x[] = {target[0], target[1]};
        CHECK(ode_manifold_nearest(m, 0, target, scale, 1e-12, x), "%d", k);
        CHECK(fabs(x[0] * x[0] + 4 * x[1] * x[1] - 4) < 1e-13);
        /* the weighted way to the target is along the gradient */
        double gx = (target[0] - x[0]) / (scale[0] * scale[0]), gy = (target[1] - x[1]) / (scale[1] * scale[1]);
        double across = (gx * 8 * x[1] - gy * 2 * x[0]) / hypot(2 * x[0], 8 * x[1]);
        CHECK(fabs(across) < 1e-6 * hypot(gx, gy), "%d: %g of %g", k, across, hypot(gx, gy));
        CHECK(gx * x[0] + 4 * gy * x[1] > 0, "%d is the near side", k);
    }
    ode_manifold_free(m);

    bool held[] = {true, false};
    c.held = held;
    m = ode_manifold_new(&c);
    double x[] = {1, 0.5}, scale[] = {1, 1}, moved, left;
    CHECK(ode_manifold_project(m, 0, x, scale, &moved, &left));
    CHECK(x[0] == 1 && fabs(x[1] - sqrt(3) / 2) < 1e-15 && left < 1e-15 && fabs(moved - (x[1] - 0.5) / sqrt(2)) < 1e-15);
    x[0] = 3;                       /* held outside: no point there */
    CHECK(!ode_manifold_project(m, 0, x, scale, &moved, &left));
    CHECK(ode_manifold_why(m) != ODE_NONE);
    ode_manifold_free(m);
    ode_manifold_free(NULL);
    lin_sparse_free(J);
}

/* The same constraint twice: dependent rows are dealt with. */
static bool twice(void *ctx, double t, const double *x, double *xi, double *J)
{
    (void)ctx;
    (void)t;
    for (int i = 0; i < 2; i++) {
        xi[i] = (i + 1) * (x[0] * x[0] + x[1] * x[1] - 1);
        if (J) {
            J[2 * i] = (i + 1) * 2 * x[0];
            J[2 * i + 1] = (i + 1) * 2 * x[1];
        }
    }
    return true;
}

static void test_dependent(void)
{
    int ptr[] = {0, 2, 4}, col[] = {0, 1, 0, 1};
    struct lin_sparse *J = lin_sparse_new(2, 2, ptr, col);
    struct ode_constraints c = {.c = 2, .n = 2, .pattern = J, .eval = twice};
    struct ode_manifold *m = ode_manifold_new(&c);
    double x[] = {3, 4}, scale[] = {1, 1}, moved, left;
    CHECK(ode_manifold_project(m, 0, x, scale, &moved, &left) && left < 1e-15);
    CHECK(fabs(x[0] - 0.6) < 1e-15 && fabs(x[1] - 0.8) < 1e-15 && fabs(moved - 4 / sqrt(2)) < 1e-14);
    ode_manifold_free(m);
    lin_sparse_free(J);
}

int main(void)
{
    lin_init();
    test_against_angle();
    test_long();
    test_pinned();
    test_vanishing();
    test_nearest();
    test_dependent();
    return CHECK_END();
}
