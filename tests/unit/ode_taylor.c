/* The Taylor method by itself, its series written by hand: closed forms, a manifold, a series
 * whose last terms vanish, one that ends in the step, one that is refused here and there. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "error.h"
#include "ode.h"

enum which { CIRCLE, POLE, LATE, TURN, GAPS };

static bool rhs(void *ctx, double t, const double *x, double *dx)
{
    switch (*(enum which *)ctx) {
    case CIRCLE: dx[0] = -x[1]; dx[1] = x[0]; break;
    case POLE:   dx[0] = x[0] * x[0]; break;
    case LATE:   dx[0] = 41 * pow(t, 40); break;
    case TURN: case GAPS: dx[0] = fabs(t - 1); break;
    }
    return true;
}

static bool series(void *ctx, double t, const double *x, int order, double scale, double *out, double *reach)
{
    *reach = INFINITY;
    switch (*(enum which *)ctx) {
    case CIRCLE:
        out[0] = x[0];
        out[1] = x[1];
        for (int k = 0; k < order; k++) {
            out[2 * k + 2] = -scale * out[2 * k + 1] / (k + 1);
            out[2 * k + 3] = scale * out[2 * k] / (k + 1);
        }
        return true;
    case POLE:
        out[0] = x[0];
        for (int k = 0; k < order; k++)
            out[k + 1] = out[k] * x[0] * scale;
        return true;
    case LATE: {
        double binomial = 1;
        for (int k = 0; k <= order; k++) {
            out[k] = binomial * pow(t, 41 - k) * pow(scale, k);
            binomial *= (41.0 - k) / (k + 1);
        }
        out[0] = x[0];
        return true;
    }
    case GAPS:
        if (fabs(t - 1) < 0.25)
            return false;
        /* fall through */
    case TURN: {
        int side = t < 1 || (t == 1 && scale < 0) ? -1 : 1;
        memset(out, 0, (size_t)(order + 1) * sizeof *out);
        out[0] = x[0];
        out[1] = scale * side * (t - 1);
        out[2] = scale * scale * side / 2;
        double s = (1 - t) / scale;
        if (s > 1e-13 && s <= 1)
            *reach = s;
        return true;
    }
    }
    return false;
}

static bool onto_circle(void *ctx, double t, double *x, const double *scale, double *moved, double *residual)
{
    (void)ctx, (void)t, (void)scale;
    double r = hypot(x[0], x[1]);
    x[0] /= r;
    x[1] /= r;
    *moved = fabs(r - 1) / scale[0];
    *residual = fabs(x[0] * x[0] + x[1] * x[1] - 1);
    return true;
}

static struct ode_result solve(enum which *which, int n, double from, const double *x, const double *times, int count, double tol, const char *method)
{
    struct ode_problem p = { .n = n, .ctx = which, .rhs = rhs, .taylor = series, .project = *which == CIRCLE ? onto_circle : NULL };
    struct ode_start start = { from, x, count, times };
    struct ode_options o = ode_options_default();
    struct ode_result r;
    struct sga_error err = { 0 };
    o.method = method;
    o.rtol = o.atol = tol;
    o.estimate_global_error = o.refine = true;
    CHECK(ode_solve(&p, &start, &o, &r, &err), "%s", err.detail);
    return r;
}

static void circle(void)
{
    enum which w = CIRCLE;
    static const double x[2] = { 1, 0 }, forth[] = { 0, 0.5, 3, 31, 100 }, back[] = { -0.25, -7, -50 };
    for (double tol = 1e-4; tol > 1e-14; tol /= 10) {
        for (int turn = 0; turn < 2; turn++) {
            int count = turn ? 3 : 5;
            const double *times = turn ? back : forth;
            struct ode_result r = solve(&w, 2, 0, x, times, count, tol, "taylor");
            CHECK(r.count == count && strcmp(r.method, "taylor") == 0, "%d", r.count);
            for (int k = 0; k < r.count; k++) {
                double e = hypot(r.samples[2 * k] - cos(times[k]), r.samples[2 * k + 1] - sin(times[k]));
                CHECK(e <= r.error[k] + 1e-15, "at %g: %g, estimate %g tol %g steps %ld", times[k], e, r.error[k], tol, r.stats.steps);
            }
            CHECK(r.max_residual < 1e-15 && r.stats.refused == 0, "%g: %g %ld", tol, r.max_residual, r.stats.refused);
            CHECK(r.worst <= 1 || (tol < 5e-13 && r.shortfall), "%g: %g", tol, r.worst);    /* rounding grows over the way */
            ode_result_free(&r);
        }
    }
}

static void pole(void)
{
    enum which w = POLE;
    static const double x[1] = { 1 }, times[] = { 0.5, 0.999, 3 };
    struct ode_result r = solve(&w, 1, 0, x, times, 3, 1e-11, "taylor");
    CHECK(r.count == 2 && r.end.reason == ODE_BLOW_UP && fabs(r.end.t - 1) < 1e-9, "%d %s %.15g", r.count, ode_reason_text(r.end.reason), r.end.t);
    CHECK(fabs(r.samples[1] - 1000) < r.error[1], "%.15g %g", r.samples[1], r.error[1]);
    ode_result_free(&r);
}

/* The coefficients up to the order are all 0 at the start: the defect at the end tells. */
static void late(void)
{
    enum which w = LATE;
    static const double x[1] = { 0 }, times[] = { 1, 1.5 };
    struct ode_result r = solve(&w, 1, 0, x, times, 2, 1e-9, "taylor");
    CHECK(r.count == 2 && fabs(r.samples[0] - 1) < 1e-8 && fabs(r.samples[1] / pow(1.5, 41) - 1) < 1e-8, "%.12g", r.samples[0]);
    ode_result_free(&r);
}

static void turn(void)
{
    static const double x[1] = { 0 }, times[] = { 0.5, 1, 1.5, 5 }, value[] = { 0.375, 0.5, 0.625, 8.5 };
    for (int gaps = 0; gaps < 2; gaps++) {
        enum which w = gaps ? GAPS : TURN;
        struct ode_result r = solve(&w, 1, 0, x, times, 4, 1e-10, "taylor");
        for (int k = 0; k < 4; k++)
            CHECK(r.count == 4 && fabs(r.samples[k] - value[k]) < 1e-9, "at %g: %.15g", times[k], r.samples[k]);
        CHECK(strcmp(r.method, gaps ? "dop853, taylor" : "taylor") == 0, "%s", r.method);
        CHECK(gaps || r.stats.steps <= 10, "%ld steps", r.stats.steps);
        ode_result_free(&r);
    }
}

static void refused(void)
{
    enum which w = CIRCLE;
    static const double x[2] = { 1, 0 }, times[] = { 1 };
    struct ode_problem p = { .n = 2, .ctx = &w, .rhs = rhs };
    struct ode_start start = { 0, x, 1, times };
    struct ode_options o = ode_options_default();
    struct ode_result r;
    struct sga_error err = { 0 };
    o.method = "taylor";
    CHECK(!ode_solve(&p, &start, &o, &r, &err) && err.code == SGA_E_NOT_SUPPORTED);
    struct ode_result fine = solve(&w, 2, 0, x, times, 1, 1e-12, "auto");
    CHECK(strstr(fine.method, "taylor") != NULL, "%s", fine.method);
    ode_result_free(&fine);
    struct ode_result coarse = solve(&w, 2, 0, x, times, 1, 1e-6, "auto");
    CHECK(strstr(coarse.method, "taylor") == NULL, "%s", coarse.method);
    ode_result_free(&coarse);
}

int main(void)
{
    circle();
    pole();
    late();
    turn();
    refused();
    return CHECK_END();
}
