/* Errors that come with a solution (companion.h), against closed forms: over many periods, where errors die away, where they grow though the motion does not,
 * near a pole, on a manifold; and that other solutions are made where distances may jump. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "error.h"
#include "ode.h"

enum which { CIRCLE, TWIST, SADDLE, FORCED, GROWTH, RICCATI, WHICH };

static int size_of(enum which w) { return w <= SADDLE ? 2 : 1; }

static bool rhs(void *ctx, double t, const double *x, double *dx)
{
    switch (*(enum which *)ctx) {
    case CIRCLE:  dx[0] = -x[1]; dx[1] = x[0]; break;
    case TWIST:   dx[0] = -(x[0] * x[0] + x[1] * x[1]) * x[1]; dx[1] = (x[0] * x[0] + x[1] * x[1]) * x[0]; break;
    case FORCED:  dx[0] = -x[0] / 2 + cos(t) / 2 - sin(t); break;
    case SADDLE:  dx[0] = x[1]; dx[1] = x[0]; break;
    case GROWTH:  dx[0] = x[0]; break;
    case RICCATI: dx[0] = 1 + x[0] * x[0]; break;
    case WHICH:   return false;
    }
    return true;
}

static void truth(enum which w, double t, double *x)
{
    switch (w) {
    case CIRCLE: case TWIST: x[0] = cos(t); x[1] = sin(t); break;
    case FORCED:  x[0] = cos(t); break;
    case SADDLE:  x[0] = exp(-t); x[1] = -exp(-t); break;
    case GROWTH:  x[0] = exp(t); break;
    case RICCATI: x[0] = tan(t); break;
    case WHICH:   break;
    }
}

static bool series(void *ctx, double t, const double *x, int order, double scale, double *out, double *reach)
{
    enum which w = *(enum which *)ctx;
    int n = size_of(w);
    double wave[2] = { cos(t) / 2, sin(t) / 2 }, other[2] = { -sin(t), cos(t) };      /* cos / 2 and -sin, with the derivatives that follow */
    double square[64];
    *reach = INFINITY;
    memcpy(out, x, (size_t)n * sizeof *x);
    for (int k = 0; k < order; k++, out += n) {
        double by = scale / (k + 1), sum = k == 0;
        switch (w) {
        case TWIST: {
            double u = 0, v = 0, q = 0;
            for (int i = 0; i <= k; i++)
                q += out[-2 * i] * out[2 * (i - k)] + out[1 - 2 * i] * out[1 + 2 * (i - k)];
            square[k] = q;
            for (int i = 0; i <= k; i++) {
                u += square[i] * out[1 - 2 * i];
                v += square[i] * out[-2 * i];
            }
            out[2] = -by * u;
            out[3] = by * v;
            break;
        }
        case CIRCLE: out[2] = -by * out[1]; out[3] = by * out[0]; break;
        case SADDLE: out[2] = by * out[1]; out[3] = by * out[0]; break;
        case GROWTH: out[1] = by * out[0]; break;
        case FORCED: {
            double c = wave[0], s = other[0];
            out[1] = by * (-out[0] / 2 + c + s);
            wave[0] = -by * wave[1];
            wave[1] = by * c;
            other[0] = -by * other[1];
            other[1] = by * s;
            break;
        }
        default:
            for (int i = 0; i <= k; i++)
                sum += out[-i] * out[i - k];
            out[1] = by * sum;
        }
    }
    return true;
}

static bool onto_circle(void *ctx, double t, double *x, const double *scale, double *moved, double *residual)
{
    double r = hypot(x[0], x[1]);
    (void)ctx, (void)t;
    x[0] /= r;
    x[1] /= r;
    *moved = fabs(r - 1) / scale[0];
    *residual = fabs(x[0] * x[0] + x[1] * x[1] - 1);
    return true;
}

enum { COUNT = 200 };

struct seen { double held, last_error, last_estimate, first_estimate; };

static struct seen run(enum which w, double from, double to, double tol, bool project)
{
    int n = size_of(w), held = 0;
    double x[2], times[COUNT], at[2];
    struct ode_problem p = { .n = n, .ctx = &w, .rhs = rhs, .taylor = series, .project = project ? onto_circle : NULL };
    struct ode_options o = ode_options_default();
    struct ode_result r;
    struct sga_error err = { 0 };
    struct seen seen = { 0 };
    for (int k = 0; k < COUNT; k++)
        times[k] = from + (to - from) * (k + 1) / COUNT;
    truth(w, from, x);
    struct ode_start start = { from, x, COUNT, times };
    o.method = "taylor";
    o.rtol = o.atol = tol;
    o.estimate_global_error = true;
    CHECK(ode_solve(&p, &start, &o, &r, &err), "%s", err.detail);
    CHECK(r.count == COUNT && r.end.reason == ODE_NONE && r.solutions == 1 && r.second.steps == 0, "%d: %d samples, %d solutions", (int)w, r.count, r.solutions);
    for (int k = 0; k < r.count; k++) {
        double e = 0;
        truth(w, times[k], at);
        for (int j = 0; j < n; j++)
            e = fmax(e, fabs(r.samples[k * n + j] - at[j]));
        held += e <= r.error[k];
        seen.last_error = e;
        seen.last_estimate = r.error[k];
        seen.first_estimate = k == 0 ? r.error[k] : seen.first_estimate;
    }
    seen.held = (double)held / COUNT;
    ode_result_free(&r);
    return seen;
}

static void check(const char *what, struct seen s, double least, double most)
{
    CHECK(s.held >= 0.97, "%s: %g of the estimates hold", what, s.held);
    CHECK(s.last_estimate >= least * s.last_error && s.last_estimate <= most * s.last_error, "%s: error %g, estimate %g", what, s.last_error, s.last_estimate);
}

static void closed_forms(void)
{
    for (double tol = 1e-4; tol > 2e-9; tol /= 10) {
        check("some periods", run(CIRCLE, 0, 20, tol, false), 1, 1e4);
        if (tol < 2e-6) {        /* else a distance is soon no longer small */
            check("many periods", run(CIRCLE, 0, 2000, tol, false), 1, 1e4);
            if (tol < 2e-7)
                check("many periods whose length grows with the amplitude", run(TWIST, 0, 500, tol, false), 1, 1e4);
            check("many periods back", run(CIRCLE, 7, -1500, tol, false), 1, 1e4);
        }
        check("on the circle", run(CIRCLE, 0, 500, tol, true), 1, 1e4);
        check("a saddle", run(SADDLE, 0, 12, tol, false), 1, 1e4);
        check("growth", run(GROWTH, 0, 30, tol, false), 1, 1e4);
        check("towards a pole", run(RICCATI, -1.5, 1.5, tol, false), 1, 1e4);
        struct seen s = run(FORCED, 0, 300, tol, false);
        CHECK(s.held >= 0.97 && s.last_estimate < 1e3 * tol && s.last_estimate < 1e3 * s.first_estimate, "errors that die away: %g held, %g, %g", s.held,
              s.first_estimate, s.last_estimate);
    }
}

static void height(void *ctx, double t, const double *x, double *g)
{
    (void)ctx, (void)t;
    g[0] = x[1] - 0.5;
}

/* Where there are events, the times of which are compared, and where implicit steps are made there are two solutions. */
static void others(void)
{
    enum which w = CIRCLE;
    static const struct ode_event spec = { 0, false };
    static const double x[2] = { 1, 0 }, times[] = { 1, 10 };
    for (int turn = 0; turn < 2; turn++) {
        struct ode_problem p = { .n = 2, .ctx = &w, .rhs = rhs, .taylor = series };
        struct ode_start start = { 0, x, 2, times };
        struct ode_options o = ode_options_default();
        struct ode_result r;
        struct sga_error err = { 0 };
        if (turn == 0)
            p.events = 1, p.event_spec = &spec, p.event = height;
        o.method = turn ? "radau" : "taylor";
        o.rtol = o.atol = 1e-7;
        o.estimate_global_error = true;
        CHECK(ode_solve(&p, &start, &o, &r, &err), "%s", err.detail);
        CHECK(r.count == 2 && r.solutions == 2 && r.second.steps > 0 && (turn || (r.happened == 4 && r.happening[3].error < 1e-5)), "%d: %d", turn, r.solutions);
        CHECK(fabs(r.samples[2] - cos(10)) <= r.error[1], "%d: %g %g", turn, r.samples[2], r.error[1]);
        ode_result_free(&r);
    }
}

int main(void)
{
    closed_forms();
    others();
    return CHECK_END();
}
