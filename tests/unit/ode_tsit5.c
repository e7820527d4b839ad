/* Tsitouras 5(4) by itself: the published numbers satisfy the order conditions, also inside the
 * step; the solution is of order 5, its polynomial of order 4; chosen and named. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "method.h"
#include "tsit5_tables.h"

enum { S = TSIT5_STAGES };

static void apply(const double *u, double *v)
{
    for (int i = 0; i < S; i++) {
        v[i] = 0;
        for (int m = 0; m < tsit5_a[i].count; m++)
            v[i] += tsit5_a[i].a[m] * u[tsit5_a[i].stage[m]];
    }
}

static double dot(const double *w, const double *v)
{
    double s = 0;
    for (int i = 0; i < S; i++)
        s += w[i] * v[i];
    return s;
}

/* The vectors of the elementary weights of all trees up to order 5, by order. */
struct trees { int count, order[17]; double value[17][S], density[17]; };

static void add(struct trees *t, int order, const double *v, double density)
{
    t->order[t->count] = order;
    t->density[t->count] = density;
    memcpy(t->value[t->count++], v, sizeof t->value[0]);
}

/* Products and applications of A to 1, as in Hairer, Norsett, Wanner I, table II.2.1-2. */
static void grow(struct trees *t)
{
    double one[S], c[S], c2[S], c3[S], c4[S], ac[S], ac2[S], ac3[S], aac[S], aac2[S], aaac[S], acac[S], v[S];
    for (int i = 0; i < S; i++) {
        one[i] = 1;
        c[i] = tsit5_c[i];
        c2[i] = c[i] * c[i];
        c3[i] = c2[i] * c[i];
        c4[i] = c3[i] * c[i];
    }
    apply(c, ac), apply(c2, ac2), apply(c3, ac3), apply(ac, aac), apply(ac2, aac2), apply(aac, aaac);
    for (int i = 0; i < S; i++)
        v[i] = c[i] * ac[i];
    apply(v, acac);
    add(t, 1, one, 1), add(t, 2, c, 2), add(t, 3, c2, 3), add(t, 3, ac, 6), add(t, 4, c3, 4), add(t, 4, v, 8);
    add(t, 4, ac2, 12), add(t, 4, aac, 24), add(t, 5, c4, 5), add(t, 5, ac3, 20), add(t, 5, acac, 40);
    add(t, 5, aac2, 60), add(t, 5, aaac, 120);
    for (int i = 0; i < S; i++)
        v[i] = c2[i] * ac[i];
    add(t, 5, v, 10);
    for (int i = 0; i < S; i++)
        v[i] = c[i] * ac2[i];
    add(t, 5, v, 15);
    for (int i = 0; i < S; i++)
        v[i] = c[i] * aac[i];
    add(t, 5, v, 30);
    for (int i = 0; i < S; i++)
        v[i] = ac[i] * ac[i];
    add(t, 5, v, 20);
}

static void test_tables(void)
{
    struct trees t = {0};
    double end[S] = {0}, error[S], at[S], far = 0;
    grow(&t);
    CHECK(t.count == 17);
    for (int s = 1; s < S; s++) {
        double sum = 0;
        for (int m = 0; m < tsit5_a[s].count; m++)
            sum += tsit5_a[s].a[m];
        CHECK(fabs(sum - tsit5_c[s]) < 4e-15 && tsit5_a[s].count == s, "stage %d: %g", s, sum - tsit5_c[s]);
    }
    for (int m = 0; m < tsit5_a[TSIT5_END].count; m++)
        end[m] = tsit5_a[TSIT5_END].a[m];
    memcpy(error, tsit5_error.a, sizeof error);
    for (int k = 0; k < t.count; k++) {
        CHECK(fabs(dot(end, t.value[k]) - 1 / t.density[k]) < 1e-14, "tree %d: %g", k, dot(end, t.value[k]) - 1 / t.density[k]);
        if (t.order[k] <= 4)
            CHECK(fabs(dot(error, t.value[k])) < 1e-14, "error, tree %d", k);
        else
            far = fmax(far, fabs(dot(error, t.value[k])));
        for (double theta = 0.1; theta <= 1.01 && t.order[k] <= 4; theta += 0.1) {
            for (int i = 0; i < S; i++) {
                const double *p = tsit5_dense[i];
                at[i] = theta * (p[0] + theta * (p[1] + theta * (p[2] + theta * p[3])));
            }
            CHECK(fabs(dot(at, t.value[k]) - pow(theta, t.order[k]) / t.density[k]) < 3e-14, "inside, tree %d at %g", k, theta);
        }
    }
    CHECK(far > 1e-5, "the estimate is of order 4 only");
}

static bool swing(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx;
    dx[0] = x[1] * x[2];
    dx[1] = -x[0] * x[2] + 0.1 * sin(t);
    dx[2] = -0.5 * x[0] * x[1];
    return true;
}

/* The end of [0, 4] with equal steps, and the middle of the last one by dense output. */
static void march(int steps, double *x, double *middle)
{
    struct ode_problem p = {.n = 3, .rhs = swing};
    struct ode_stats stats = {0};
    struct ode_field field = {.p = &p, .stats = &stats};
    double unit[] = {1, 1, 1}, f[3], dx[3], y[3];
    void *state = ode_tsit5.alloc(&p);
    x[0] = 0.2, x[1] = 0.9, x[2] = 0.8;
    for (int k = 0; k < steps; k++) {
        double t = 4.0 * k / steps;
        swing(NULL, t, x, f);
        struct ode_step s = {.n = 3, .t = t, .h = 4.0 / steps, .x = x, .f = f, .rtol = 1, .atol = 1, .unit = unit, .dx = dx};
        CHECK(ode_tsit5.attempt(state, &field, &s) == ODE_STEPPED && s.f_end);
        ode_tsit5.dense_begin(state, &field, &s);
        ode_tsit5.dense_at(state, &s, 0.5, middle);
        ode_tsit5.dense_at(state, &s, 1, y);
        for (int j = 0; j < 3; j++) {
            x[j] += dx[j];
            CHECK(fabs(y[j] - x[j]) < 1e-14);
        }
        swing(NULL, t + s.h, x, f);
        for (int j = 0; j < 3; j++)
            CHECK(fabs(f[j] - s.f_end[j]) < 1e-14);
    }
    ode_tsit5.free(state);
}

static void test_order(void)
{
    double ref[3], middle[3], x[3], y[3], error[2];
    march(4096, ref, middle);
    for (int k = 0; k < 2; k++) {
        march(32 << k, x, y);
        error[k] = 0;
        for (int j = 0; j < 3; j++)
            error[k] = fmax(error[k], fabs(x[j] - ref[j]));
    }
    double order = log2(error[0] / error[1]);
    CHECK(order > 4.6 && order < 6, "the global error falls as h^%g", order);
}

/* A rotation with a radius that is held: through the driver, with constraints or without,
 * named or chosen; many samples. */
static bool turn(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx, (void)t;
    dx[0] = -x[1];
    dx[1] = x[0];
    return true;
}

static bool circle(void *ctx, double t, double *x, const double *scale, double *moved, double *residual)
{
    (void)ctx, (void)t;
    double r = hypot(x[0], x[1]);
    *moved = fabs(r - 1) / scale[0];
    x[0] /= r;
    x[1] /= r;
    *residual = fabs(hypot(x[0], x[1]) - 1);
    return true;
}

static void test_march(void)
{
    double start[] = {1, 0}, times[301];
    for (int k = 0; k <= 300; k++)
        times[k] = 0.05 * k;
    struct ode_start s = {0, start, 301, times};
    for (int k = 0; k < 8; k++) {
        struct ode_problem p = {.n = 2, .rhs = turn, .project = k % 2 ? circle : NULL};
        struct ode_options o = ode_options_default();
        struct ode_result r;
        o.method = k < 4 ? "tsit5" : NULL;
        o.rtol = o.atol = k % 4 < 2 ? 2e-3 : 1e-6;
        o.estimate_global_error = k == 2;
        CHECK(ode_solve(&p, &s, &o, &r, NULL) && r.count == 301);
        CHECK(strcmp(r.method, k < 4 || k % 4 < 2 ? "tsit5" : "dop853") == 0, "%d: %s", k, r.method);
        double worst = 0;
        for (int i = 0; i < r.count; i++)
            worst = fmax(worst, hypot(r.samples[2 * i] - cos(times[i]), r.samples[2 * i + 1] - sin(times[i])));
        CHECK(worst < 300 * o.rtol, "%d: %g", k, worst);
        CHECK(!p.project || r.max_residual < 1e-15);
        CHECK(k != 2 || (worst <= r.max_error && r.max_error < 300 * worst), "%g, estimated %g", worst, r.max_error);
        ode_result_free(&r);
    }
}

int main(void)
{
    test_tables();
    test_order();
    test_march();
    return CHECK_END();
}
