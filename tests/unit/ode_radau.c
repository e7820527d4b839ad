/* The implicit method: its numbers satisfy their conditions, its order shows, stiff test
 * problems end at their published values, and the choice of the method is right. */
#include <string.h>

#include "check.h"
#include "error.h"
#include "lin_sparse.h"
#include "mem.h"
#include "radau_tables.h"
#include "stiff_problems.h"

/* A = (T D TI)^-1 by its defining property on powers: A c^(k-1) = c^k / k, tested as
 * A^-1 c^k = k c^(k-1); the weights being the last row, this is the order 2 s - 1 of
 * collocation at Radau points, for which the nodes' polynomial must be orthogonal. */
static void test_tables(void)
{
    for (int i = 0; i < RADAU_TABLES; i++) {
        const struct radau_table *t = radau_tables + i;
        int s = t->s;
        for (int k = 1; k <= s; k++) {
            double w[RADAU_STAGES], u[RADAU_STAGES];
            for (int r = 0; r < s; r++) {
                w[r] = 0;
                for (int j = 0; j < s; j++)
                    w[r] += t->TI[r][j] * pow(t->c[j], k);
            }
            u[0] = t->gamma * w[0];
            for (int p = 0; p < s / 2; p++) {
                u[1 + 2 * p] = t->re[p] * w[1 + 2 * p] - t->im[p] * w[2 + 2 * p];
                u[2 + 2 * p] = t->im[p] * w[1 + 2 * p] + t->re[p] * w[2 + 2 * p];
            }
            for (int r = 0; r < s; r++) {
                double v = 0;
                for (int j = 0; j < s; j++)
                    v += t->T[r][j] * u[j];
                CHECK(fabs(v - k * pow(t->c[r], k - 1)) < 2e-12, "s %d, k %d: %g", s, k, v - k * pow(t->c[r], k - 1));
            }
            double d = 0;      /* the defect of x = t^k: k 0^(k-1) - u'(0) = 0 as k <= s */
            for (int j = 0; j < s; j++)
                d += t->defect[j] * pow(t->c[j], k);
            CHECK(fabs(d + (k == 1)) < 1e-11, "s %d, k %d: %g", s, k, d);
            double sum = 0;
            for (int j = 0; j <= s; j++)
                sum += t->bary[j] * (j ? pow(t->c[j - 1], k - 1) : k == 1);
            CHECK(fabs(sum) < 1e-10, "weights, s %d, k %d: %g", s, k, sum);
        }
        for (int k = 0; k < s - 1; k++) {       /* int_0^1 prod (x - c_i) x^k dx = 0, by Gauss-free expansion */
            double p[RADAU_STAGES + 1] = {1}, integral = 0;
            for (int j = 0; j < s; j++)
                for (int q = j + 1; q >= 0; q--)
                    p[q] = (q ? p[q - 1] : 0) - t->c[j] * (q <= j ? p[q] : 0);
            for (int q = 0; q <= s; q++)
                integral += p[q] / (q + k + 1);
            CHECK(fabs(integral) < 1e-15, "s %d, k %d: %g", s, k, integral);
        }
    }
}

static struct ode_result solve(const struct ode_problem *p, const double *x, double stop, int count, double rtol,
                               double atol, const char *method)
{
    double *t = sga_malloc((size_t)count * sizeof *t);
    for (int k = 0; k < count; k++)
        t[k] = stop * (k + 1) / count;
    struct ode_start start = {0, x, count, t};
    struct ode_options o = ode_options_default();
    o.rtol = rtol;
    o.atol = atol;
    o.method = method;
    struct ode_result r;
    struct sga_error err = {0};
    CHECK(ode_solve(p, &start, &o, &r, &err), "%s", err.detail);
    free(t);
    return r;
}

static void test_published(const char *method, double most)
{
    for (int i = 0; i < STIFF_PROBLEMS; i++) {
        const struct stiff_problem *s = stiff_problems + i;
        for (double tol = 1e-4; tol > 5e-13; tol *= 0.01) {
            struct ode_problem p = {.n = s->n, .rhs = s->rhs};
            struct ode_result r = solve(&p, s->x, s->stop, 1, tol, tol * s->atol, method);
            CHECK(r.end.reason == ODE_NONE && r.count == 1, "%s at %g: %s", s->name, tol, r.end.detail);
            double e = 0;
            for (int j = 0; r.count && j < s->n; j++)
                e = fmax(e, fabs(r.samples[j] - s->end[j]) / (fabs(s->end[j]) + s->atol));
            CHECK(e < 200 * tol + 1e-12, "%s at %g: %g", s->name, tol, e);
            CHECK(strstr(r.method, "radau") && r.stats.steps < most, "%s at %g: %ld steps", s->name, tol, r.stats.steps);
            ode_result_free(&r);
        }
    }
}

static bool robertson_jac(void *c, double t, const double *x, double *J)
{
    (void)c;
    (void)t;
    double rows[9] = {-0.04, 1e4 * x[2], 1e4 * x[1], 0.04, -1e4 * x[2] - 6e7 * x[1], -1e4 * x[1], 0, 6e7 * x[1], 0};
    for (int i = 0; i < 9; i++)
        J[i] = rows[i];
    return true;
}

/* Given and differenced Jacobians lead to the same result for about the same work. */
static void test_jacobian(void)
{
    double x[] = {1, 0, 0};
    struct ode_problem plain = {.n = 3, .rhs = robertson}, given = {.n = 3, .rhs = robertson, .jacobian = robertson_jac};
    struct ode_result a = solve(&plain, x, 1e6, 7, 1e-8, 1e-16, "radau"), b = solve(&given, x, 1e6, 7, 1e-8, 1e-16, "radau");
    CHECK(a.count == 7 && b.count == 7);
    for (int k = 0; k < 21; k++)
        CHECK(fabs(a.samples[k] - b.samples[k]) < 1e-7 * fabs(b.samples[k]), "%d: %g", k, a.samples[k] - b.samples[k]);
    CHECK(b.stats.evaluations < a.stats.evaluations && a.stats.steps < 1.2 * b.stats.steps, "%ld %ld", a.stats.steps, b.stats.steps);
    CHECK(b.stats.jacobians > 0 && b.stats.factorisations >= b.stats.jacobians);
    ode_result_free(&a);
    ode_result_free(&b);
}

/* Samples between the steps are as good as those at their ends, many or few. */
static void test_samples(void)
{
    double x[] = {2, 0, 1};
    for (int count = 3; count < 1000; count *= 4)
        for (double tol = 1e-5; tol > 1e-12; tol *= 0.01) {
            struct ode_problem p = {.n = 3, .rhs = rotating};
            struct ode_result r = solve(&p, x, 3, count, tol, tol, "radau");
            CHECK(r.count == count);
            double worst = 0;
            for (int k = 0; k < r.count; k++) {
                double t = 3.0 * (k + 1) / count;
                worst = fmax(worst, fabs(r.samples[3 * k] - (cos(t) + exp(-1000 * t) * cos(1000 * t))));
                worst = fmax(worst, fabs(r.samples[3 * k + 1] - (sin(t) - exp(-1000 * t) * sin(1000 * t))));
            }
            CHECK(worst < 30 * tol, "%d at %g: %g", count, tol, worst);
            ode_result_free(&r);
        }
}

/* Without a relative tolerance the absolute one is what errors are held against: x' = -k (x - cos t) - sin t, x = cos t. */
static bool follows(void *c, double t, const double *x, double *f)
{
    (void)c;
    f[0] = -1000 * (x[0] - cos(t)) - sin(t);
    return true;
}

static void test_absolute(void)
{
    double x[] = {1};
    for (double tol = 1e-4; tol > 1e-11; tol *= 0.01) {
        struct ode_problem p = {.n = 1, .rhs = follows};
        struct ode_result r = solve(&p, x, 10, 20, 0, tol, "radau");
        CHECK(r.end.reason == ODE_NONE && r.count == 20, "%g: %s", tol, r.end.detail);
        for (int k = 0; k < r.count; k++)
            CHECK(fabs(r.samples[k] - cos(0.5 * (k + 1))) < 10 * tol, "%g: %g", tol, r.samples[k] - cos(0.5 * (k + 1)));
        ode_result_free(&r);
    }
}

enum { CELLS = 200 };

/* Heat on a line with a cubic sink, by lines; banded, so the linear systems are sparse. */
static bool heat(void *c, double t, const double *x, double *dx)
{
    (void)c;
    (void)t;
    double q = (CELLS + 1.0) * (CELLS + 1.0);
    for (int i = 0; i < CELLS; i++)
        dx[i] = q * ((i ? x[i - 1] : 0) - 2 * x[i] + (i < CELLS - 1 ? x[i + 1] : 0)) - x[i] * x[i] * x[i];
    return true;
}

static void test_sparse(void)
{
    int ptr[CELLS + 1] = {0}, col[3 * CELLS];
    double x[CELLS];
    for (int i = 0; i < CELLS; i++) {
        ptr[i + 1] = ptr[i];
        for (int j = i - 1; j <= i + 1; j++)
            if (j >= 0 && j < CELLS)
                col[ptr[i + 1]++] = j;
        x[i] = sin(M_PI * (i + 1) / (CELLS + 1.0)) * (1 + (i % 7 == 0));
    }
    struct lin_sparse *band = lin_sparse_new(CELLS, CELLS, ptr, col);
    struct ode_problem sparse = {.n = CELLS, .rhs = heat, .pattern = band}, full = {.n = CELLS, .rhs = heat};
    struct ode_result a = solve(&sparse, x, 0.5, 3, 1e-9, 1e-9, NULL), b = solve(&full, x, 0.5, 3, 1e-6, 1e-6, "radau");
    CHECK(a.count == 3 && b.count == 3 && strstr(a.method, "radau"), "%s", a.method);
    for (int k = 0; k < 3 * CELLS; k++)
        CHECK(fabs(a.samples[k] - b.samples[k]) < 1e-5, "%d: %g", k, a.samples[k] - b.samples[k]);
    CHECK(a.stats.steps < 400, "%ld", a.stats.steps);
    /* three colours for a band of three: a Jacobian costs six evaluations */
    struct ode_result c = solve(&sparse, x, 0.5, 3, 1e-6, 1e-6, "radau");
    CHECK(c.stats.evaluations < b.stats.evaluations / 2, "%ld %ld", c.stats.evaluations, b.stats.evaluations);
    ode_result_free(&a);
    ode_result_free(&b);
    ode_result_free(&c);
    lin_sparse_free(band);
}

/* Where nothing is stiff the explicit method stays; the implicit one can be asked for. */
static bool pendulum(void *c, double t, const double *x, double *dx)
{
    (void)c;
    (void)t;
    dx[0] = x[1];
    dx[1] = -sin(x[0]);
    return true;
}

static void test_choice(void)
{
    double x[] = {1, 0};
    struct ode_problem p = {.n = 2, .rhs = pendulum};
    struct ode_result a = solve(&p, x, 1000, 5, 1e-10, 1e-10, NULL), b = solve(&p, x, 1000, 5, 1e-11, 1e-11, "radau");
    CHECK(strcmp(a.method, "dop853") == 0 && strcmp(b.method, "radau") == 0 && a.count == 5 && b.count == 5);
    CHECK(a.stats.implicit_steps == 0 && b.stats.implicit_steps == b.stats.steps);
    for (int k = 0; k < 10; k++)
        CHECK(fabs(a.samples[k] - b.samples[k]) < 1e-6, "%g", a.samples[k] - b.samples[k]);
    ode_result_free(&a);
    ode_result_free(&b);
}

/* The motion is slow, x = exp(-2 t), y = exp(-t); what is off it dies away in a millionth of the time. */
static bool kaps(void *c, double t, const double *x, double *dx)
{
    (void)c;
    (void)t;
    dx[0] = -(1e6 + 2) * x[0] + 1e6 * x[1] * x[1];
    dx[1] = x[0] - x[1] * (1 + x[1]);
    return true;
}

/* No tolerance takes many times the work of the next one: not for an old Jacobian, and not to follow what a step has left off the slow motion. */
static void test_even_work(void)
{
    double x[] = {1, 1}, most = 0, error = 0;
    struct ode_problem p = {.n = 2, .rhs = kaps};
    for (int k = 24; k <= 96; k++) {
        double tol = pow(10, -k / 8.0);
        struct ode_result r = solve(&p, x, 10, 4, tol, tol, NULL);
        CHECK(r.count == 4 && r.stats.implicit_steps > 0 && r.stats.refused < r.stats.steps, "%g: %ld steps, %ld refused", tol, r.stats.steps, r.stats.refused);
        most = fmax(most, (double)r.stats.evaluations * pow(tol, 0.1));
        for (int i = 0; i < r.count; i++)
            error = fmax(error, fabs(r.samples[2 * i + 1] - exp(-2.5 * (i + 1))) / tol);
        ode_result_free(&r);
    }
    CHECK(most < 600, "%g evaluations", most);
    CHECK(error < 10, "%g tolerances", error);
}

int main(void)
{
    test_even_work();
    test_tables();
    test_published("radau", 1500);
    test_published(NULL, 4000);
    test_jacobian();
    test_samples();
    test_absolute();
    test_sparse();
    test_choice();
    return CHECK_END();
}
