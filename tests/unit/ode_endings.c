/* Solutions that end: where, why, and that no sample lies past the end. */
#include <math.h>
#include <string.h>

#include "budget.h"
#include "check.h"
#include "ode.h"

static bool square(void *c, double t, const double *x, double *dx)      /* 1/(1-t) */
{
    (void)c; (void)t;
    dx[0] = x[0] * x[0];
    return true;
}
static bool slow_pole(void *c, double t, const double *x, double *dx)   /* (1-t)^-10 */
{
    (void)c; (void)t;
    dx[0] = 10 * pow(x[0], 1.1);
    return true;
}
static bool logarithm(void *c, double t, const double *x, double *dx)   /* -log(1-t) */
{
    (void)c; (void)t;
    dx[0] = exp(x[0]);
    return true;
}
static bool root(void *c, double t, const double *x, double *dx)        /* sqrt(1-t) */
{
    (void)c; (void)t;
    dx[0] = -1 / (2 * x[0]);
    return x[0] != 0;
}
static bool tangent(void *c, double t, const double *x, double *dx)     /* tan t, sec^2 t */
{
    (void)c; (void)t;
    dx[0] = x[1];
    dx[1] = 2 * x[0] * x[1];
    return true;
}
/* Domain x > 0, crossed with slope -1 at t = 1. */
static bool half_line(void *c, double t, const double *x, double *dx)
{
    (void)c; (void)t;
    dx[0] = -1 - x[0] * 0;
    return x[0] > 0;
}
/* exp(2 sqrt(1-t) - 2): no value beyond 1, where the slope becomes infinite. */
static bool edge_in_time(void *c, double t, const double *x, double *dx)
{
    (void)c;
    dx[0] = -x[0] / sqrt(1 - t);
    return true;       /* the NaN beyond is for the driver to see */
}
/* x = 1 - t, log(x) in it */
static bool logs(void *c, double t, const double *x, double *dx)
{
    (void)c;
    dx[0] = -1 + (log(x[0]) - log(1 - t));
    return true;
}
static bool square_back(void *c, double t, const double *x, double *dx) /* 1/(t+1), backwards */
{
    (void)c; (void)t;
    dx[0] = -x[0] * x[0];
    return true;
}
static bool no_start(void *c, double t, const double *x, double *dx)
{
    (void)c; (void)t;
    dx[0] = 1 / (x[0] - 1);
    return isfinite(dx[0]);
}
/* Blow-up beyond the range of doubles before the pole is resolved. */
static bool near_linear(void *c, double t, const double *x, double *dx)
{
    (void)c; (void)t;
    dx[0] = 100 * pow(x[0], 1.01);
    return isfinite(dx[0]);
}

static const struct {
    const char *name;
    int n;
    bool (*rhs)(void *, double, const double *, double *);
    double from, x0, x1, to;
    enum ode_reason reason;
    double at, tol;
} endings[] = {
    {"x^2", 1, square, 0, 1, 0, 2, ODE_BLOW_UP, 1, 1e-7},
    {"x^1.1", 1, slow_pole, 0, 1, 0, 2, ODE_BLOW_UP, 1, 1e-7},
    {"exp x", 1, logarithm, 0, 0, 0, 5, ODE_BLOW_UP, 1, 1e-7},
    {"-1/2x", 1, root, 0, 1, 0, 2, ODE_BLOW_UP, 1, 1e-7},
    {"tan", 2, tangent, -1.5707963267948966, 0, 1, 10, ODE_BLOW_UP, 0, 1e-7},
    {"half line", 1, half_line, 0, 1, 0, 2, ODE_LEFT_DOMAIN, 1, 1e-9},
    {"edge in time", 1, edge_in_time, 0, 1, 0, 2, ODE_BLOW_UP, 1, 1e-9},
    {"logs", 1, logs, 0, 1, 0, 2, ODE_LEFT_DOMAIN, 1, 1e-7},
    {"x^2 backwards", 1, square_back, 1, 0.5, 0, -7, ODE_BLOW_UP, -1, 1e-7},
    {"no start", 1, no_start, 3, 1, 0, 4, ODE_LEFT_DOMAIN, 3, 0},
    {"x^1.01", 1, near_linear, 0, 1, 0, 2, ODE_BLOW_UP, 1, 1e-2},
};

enum { COUNT = 101 };

static void test_endings(const char *method, bool estimate, double tol)
{
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        struct ode_problem p = {.n = endings[i].n, .rhs = endings[i].rhs};
        double x[] = {endings[i].x0, endings[i].x1}, t[COUNT];
        for (int k = 0; k < COUNT; k++)
            t[k] = endings[i].from + (endings[i].to - endings[i].from) * k / (COUNT - 1);
        struct ode_start start = {endings[i].from, x, COUNT, t};
        struct ode_options o = ode_options_default();
        o.method = method;
        o.estimate_global_error = estimate;
        o.rtol = o.atol = tol;
        struct ode_result r;
        const char *name = endings[i].name;
        CHECK(ode_solve(&p, &start, &o, &r, NULL));
        CHECK(r.end.reason == endings[i].reason, "%s: %s, %s", name,
              ode_reason_text(r.end.reason), r.end.detail);
        CHECK(fabs(r.end.t - endings[i].at) <= endings[i].tol * fmax(1, tol / 1e-9), "%s ends at 1 %+g", name, r.end.t - endings[i].at);
        CHECK(r.end.detail[0] && strlen(r.end.detail) < 200);
        CHECK((r.end.variable >= 0) == (r.end.reason == ODE_BLOW_UP), "%s", name);
        int due = 0;
        double direction = endings[i].to < endings[i].from ? -1 : 1;
        while (due < COUNT && (t[due] - endings[i].at) * direction < -1e-3 && tol < 1e-6)
            due++;
        CHECK(r.count >= due && (r.count == 0 || (t[r.count - 1] - r.end.t) * direction <= 0),
              "%s: %d of %d samples", name, r.count, due);
        CHECK(r.stats.steps < 30000, "%s: %ld", name, r.stats.steps);
        CHECK((r.error != NULL) == estimate);
        ode_result_free(&r);
    }
}

/* The domain is left where stages look ahead, not the solution: no ending. */
static bool decay(void *c, double t, const double *x, double *dx)
{
    (void)c; (void)t;
    dx[0] = x[0] * log(x[0]);       /* x = exp(-e^t) from exp(-1) */
    return x[0] > 0;
}

static void test_no_false_ending(void)
{
    struct ode_problem p = {.n = 1, .rhs = decay};
    double x[] = {exp(-1)}, t[] = {1, 2, 3};
    struct ode_start start = {0, x, 3, t};
    struct ode_options o = ode_options_default();
    o.first_step = 3;
    struct ode_result r;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.count == 3 && r.stats.refused > 0,
          "%d %s", r.count, r.end.detail);
    for (int k = 0; k < r.count; k++)
        CHECK(fabs(r.samples[k] - exp(-exp(t[k]))) < 1e-8, "%g", r.samples[k]);
    ode_result_free(&r);
}

static bool stiff(void *c, double t, const double *x, double *dx)
{
    (void)c;
    dx[0] = -1e9 * (x[0] - cos(t));
    return true;
}

static void test_hopeless(void)
{
    struct ode_problem p = {.n = 1, .rhs = stiff};
    double x[] = {1}, t[] = {1e-7, 1000};
    struct ode_start start = {0, x, 2, t};
    struct ode_options o = ode_options_default();
    struct ode_result r;
    o.method = "dop853";
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.end.reason == ODE_STEP_LIMIT && r.count == 1);
    CHECK(strstr(r.end.detail, "stiff") && strstr(r.end.detail, "implicit"), "%s", r.end.detail);
    CHECK(r.stats.steps < 200000, "foreseen after %ld", r.stats.steps);
    ode_result_free(&r);
    o.max_steps = 100;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.end.reason == ODE_STEP_LIMIT);
    CHECK(r.stats.steps + r.stats.refused == 100 && r.end.t < 1);
    ode_result_free(&r);
    /* chosen by itself, the implicit method gets there */
    o = ode_options_default();
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.end.reason == ODE_NONE && r.count == 2);
    CHECK(fabs(r.samples[1] - cos(1000)) < 1e-8, "%g", r.samples[1] - cos(1000));
    CHECK(strstr(r.method, "radau") && r.stats.steps < 5000, "%s %ld", r.method, r.stats.steps);
    ode_result_free(&r);
}

static bool stop_now(void *ctx)
{
    return --*(int *)ctx < 0;
}

static void test_budget(void)
{
    struct ode_problem p = {.n = 1, .rhs = stiff};
    double x[] = {1}, t[] = {0, 1000};
    struct ode_start start = {0, x, 2, t};
    struct ode_options o = ode_options_default();
    int looks = 5;
    struct sga_budget b = {.cancelled = stop_now, .cancel_ctx = &looks};
    o.budget = &b;
    struct ode_result r;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.end.reason == ODE_CANCELLED && r.count == 1);
    CHECK(r.stats.steps + r.stats.refused <= 40, "%ld", r.stats.steps);
    ode_result_free(&r);
    struct sga_budget late = {.deadline = sga_now() - 1, .seconds = 3};
    o.budget = &late;
    o.estimate_global_error = true;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.end.reason == ODE_TIME_LIMIT && r.stats.steps == 0);
    CHECK(strstr(r.end.detail, "3 seconds"), "%s", r.end.detail);
    ode_result_free(&r);
}

/* `why` says what the field's refusal means. */
static bool pivot_lost(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx; (void)x;
    dx[0] = 1;
    return t < 1;
}
static enum ode_reason because(void *ctx)
{
    (void)ctx;
    return ODE_SINGULAR;
}
static void test_why(void)
{
    struct ode_problem p = {.n = 1, .rhs = pivot_lost, .why = because};
    double x[] = {1}, t[] = {0.5, 2};
    struct ode_start start = {0, x, 2, t};
    struct ode_options o = ode_options_default();
    struct ode_result r;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.end.reason == ODE_SINGULAR && r.count == 1);
    CHECK(fabs(r.end.t - 1) < 1e-14, "%g", r.end.t - 1);
    CHECK(strcmp(ode_reason_text(r.end.reason), "singular") == 0 && ode_reason_what(ODE_BLOW_UP)[0]);
    ode_result_free(&r);
}

int main(void)
{
    test_endings(NULL, false, 1e-9);
    test_endings(NULL, true, 1e-12);
    test_endings(NULL, false, 1e-4);
    test_endings("radau", false, 1e-9);
    test_endings("radau", true, 1e-11);
    test_no_false_ending();
    test_hopeless();
    test_budget();
    test_why();
    return CHECK_END();
}
