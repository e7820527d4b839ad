/* DOP853 by itself: the published numbers satisfy the order conditions, the step is of
 * order 8, the dense output of order 7, and its derivative meets the field at the ends. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "dop853_tables.h"
#include "method.h"

static void test_row_sums(void)
{
    for (int s = 0; s < DOP853_ALL; s++) {
        double sum = 0, size = 1;
        for (int m = 0; m < dop853_a[s].count; m++) {
            CHECK(dop853_a[s].stage[m] < s);
            sum += dop853_a[s].a[m];
            size += fabs(dop853_a[s].a[m]);
        }
        CHECK(fabs(sum - dop853_c[s]) < 2e-16 * size, "stage %d: %g", s, sum - dop853_c[s]);
    }
}

/* sum_i w_i v_i over the stages of a row */
static double dot(const struct sga_row *w, const double *v)
{
    double s = 0;
    for (int m = 0; m < w->count; m++)
        s += w->a[m] * v[w->stage[m]];
    return s;
}

/* v_i = sum_j a_ij u_j */
static void apply(const double *u, double *v)
{
    for (int i = 0; i < DOP853_ALL; i++)
        v[i] = dot(&dop853_a[i], u);
}

/* Bushy trees of order k+1: b c^k = 1/(k+1). Tall ones: b A^m c^k = k!/(k+m+1)!, and
 * products c^l (A c^k). All trees of these kinds to order 8. */
static void test_order_conditions(void)
{
    const struct sga_row *b = &dop853_a[DOP853_END];
    for (int k = 0; k <= 7; k++) {
        double v[DOP853_ALL], u[DOP853_ALL], want = 1.0 / (k + 1);
        for (int i = 0; i < DOP853_ALL; i++)
            v[i] = pow(dop853_c[i], k);
        CHECK(fabs(dot(b, v) - want) < 1e-14, "c^%d: %g", k, dot(b, v) - want);
        for (int m = 1; k + m <= 7; m++) {
            apply(v, u);
            memcpy(v, u, sizeof v);
            want /= k + m + 1;
            CHECK(fabs(dot(b, v) - want) < 1e-14, "A^%d c^%d: %g", m, k, dot(b, v) - want);
            for (int l = 1; l + k + m <= 7; l++) {
                double w[DOP853_ALL];    /* c^l times A^m c^k */
                double times = want * (k + m + 1) / (k + m + l + 1);
                for (int i = 0; i < DOP853_ALL; i++)
                    w[i] = pow(dop853_c[i], l) * v[i];
                CHECK(fabs(dot(b, w) - times) < 1e-14, "c^%d A^%d c^%d: %g", l, m, k,
                      dot(b, w) - times);
            }
        }
    }
    double v[DOP853_ALL], sum5 = 0, sum3 = 0;
    for (int k = 0; k <= 4; k++) {           /* the embedded formula of order 5 */
        for (int i = 0; i < DOP853_ALL; i++)
            v[i] = pow(dop853_c[i], k);
        CHECK(fabs(dot(&dop853_error5, v)) < 1e-14, "error5 c^%d: %g", k, dot(&dop853_error5, v));
        if (k <= 2)
            CHECK(fabs(dot(&dop853_weights3, v) - 1.0 / (k + 1)) < 1e-14, "weights3 c^%d", k);
    }
    for (int i = 0; i < DOP853_ALL; i++)
        v[i] = pow(dop853_c[i], 5);
    sum5 = dot(&dop853_error5, v);
    for (int i = 0; i < DOP853_ALL; i++)
        v[i] = pow(dop853_c[i], 3);
    sum3 = dot(&dop853_weights3, v) - 0.25;
    CHECK(fabs(sum5) > 1e-4 && fabs(sum3) > 1e-4, "the estimates are of order 5 and 3 only");
}

/* x0' = x1 x2, x1' = -x0 x2, x2' = -k x0 x1: Jacobi's sn, cn, dn. */
static bool jacobi(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx;
    (void)t;
    dx[0] = x[1] * x[2];
    dx[1] = -x[0] * x[2];
    dx[2] = -0.5 * x[0] * x[1];
    return true;
}

/* One step from 0.3 of a reference made of 400 small steps; errors at the end, and the
 * largest inside by dense output; the defect of the polynomial's slope at both ends. */
static void one_step(double h, double *end, double *inside, double *slope)
{
    struct ode_problem p = {.n = 3, .rhs = jacobi};
    struct ode_stats stats = {0};
    struct ode_field field = {.p = &p, .stats = &stats};
    double unit[] = {1, 1, 1}, x[] = {0.2, 0.9, 0.8}, f[3], dx[3], x1[3], f1[3];
    double ref[3], g[3], d[3], y[3];
    const struct ode_problem three = {.n = 3};
    void *big = ode_dop853.alloc(&three), *small = ode_dop853.alloc(&three);
    jacobi(NULL, 0, x, f);
    struct ode_step s = {.n = 3, .h = h, .x = x, .f = f, .rtol = 1, .atol = 1, .unit = unit,
                         .dx = dx, .x1 = x1, .f1 = f1};
    CHECK(ode_dop853.attempt(big, &field, &s) == ODE_STEPPED);
    for (int j = 0; j < 3; j++)
        x1[j] = x[j] + dx[j];
    jacobi(NULL, 0, x1, f1);
    CHECK(ode_dop853.dense_begin(big, &field, &s));
    *inside = *end = *slope = 0;
    memcpy(ref, x, sizeof ref);
    enum { PARTS = 16 };
    for (int k = 0; k <= PARTS; k++) {
        ode_dop853.dense_at(big, &s, (double)k / PARTS, y);
        for (int j = 0; j < 3; j++) {
            *inside = fmax(*inside, fabs(y[j] - ref[j]));
            if (k == PARTS)
                *end = fmax(*end, fabs(x1[j] - ref[j]));
        }
        struct ode_step q = {.n = 3, .h = h / PARTS, .x = ref, .f = g, .rtol = 1, .atol = 1,
                             .unit = unit, .dx = d};
        jacobi(NULL, 0, ref, g);
        ode_dop853.attempt(small, &field, &q);
        for (int j = 0; j < 3; j++)
            ref[j] += d[j];
    }
    double e = 1e-4, a[3], b[3];
    ode_dop853.dense_at(big, &s, e, a);
    ode_dop853.dense_at(big, &s, 1 - e, b);
    for (int j = 0; j < 3; j++)
        *slope = fmax(*slope, fmax(fabs((a[j] - x[j]) / (e * h) - f[j]),
                                   fabs((x1[j] - b[j]) / (e * h) - f1[j])));
    ode_dop853.free(big);
    ode_dop853.free(small);
}

/* Global error over [0, 8] with equal steps. */
static void march(int steps, double *x)
{
    struct ode_problem p = {.n = 3, .rhs = jacobi};
    struct ode_stats stats = {0};
    struct ode_field field = {.p = &p, .stats = &stats};
    double unit[] = {1, 1, 1}, f[3], dx[3];
    const struct ode_problem three = {.n = 3};
    void *state = ode_dop853.alloc(&three);
    x[0] = 0.2;
    x[1] = 0.9;
    x[2] = 0.8;
    for (int k = 0; k < steps; k++) {
        jacobi(NULL, 0, x, f);
        struct ode_step s = {.n = 3, .h = 8.0 / steps, .x = x, .f = f, .rtol = 1, .atol = 1,
                             .unit = unit, .dx = dx};
        ode_dop853.attempt(state, &field, &s);
        for (int j = 0; j < 3; j++)
            x[j] += dx[j];
    }
    ode_dop853.free(state);
}

static void test_global_order(void)
{
    double ref[3], x[3], error[3];
    march(400, ref);
    for (int k = 0; k < 3; k++) {
        march(12 << k, x);
        error[k] = 0;
        for (int j = 0; j < 3; j++)
            error[k] = fmax(error[k], fabs(x[j] - ref[j]));
    }
    double order = log2(error[0] / error[2]) / 2;
    CHECK(order > 7.6 && order < 9, "the global error falls as h^%g (%g %g %g)", order, error[0],
          error[1], error[2]);
}

static void test_dense_order(void)
{
    double end, inside, slope, e, i, s;
    one_step(0.4, &end, &inside, &slope);
    one_step(0.1, &e, &i, &s);
    double order = log2(inside / i) / 2;
    CHECK(order > 7.7 && order < 8.5, "inside the error falls as h^%g", order);
    CHECK(slope < 2e-5 && s < 5e-6 && end < 1e-10 && e < 1e-15, "%g %g %g %g", slope, s, end, e);
}

int main(void)
{
    test_row_sums();
    test_order_conditions();
    test_global_order();
    test_dense_order();
    return CHECK_END();
}
