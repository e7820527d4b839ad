/* Work against accuracy of the integrator and of GSL's odeiv2, at equal true error, as
 * ratios of one run: the same compiled field, the same end, tolerances swept, the time at
 * an error read off between them. tests/bench/ode.sh BUILD_DIR */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_matrix.h>
#include <gsl/gsl_odeiv2.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "stiff_problems.h"

static bool pendulum(void *c, double t, const double *x, double *dx)
{
    (void)c;
    (void)t;
    dx[0] = x[1];
    dx[1] = -sin(x[0]);
    return true;
}

static bool kepler(void *c, double t, const double *x, double *dx)
{
    (void)c;
    (void)t;
    double r = sqrt(x[0] * x[0] + x[1] * x[1]), q = r * r * r;
    dx[0] = x[2];
    dx[1] = x[3];
    dx[2] = -x[0] / q;
    dx[3] = -x[1] / q;
    return true;
}

static const struct stiff_problem smooth[] = {
    {"pendulum", 2, pendulum, {1, 0}, 20, 1, {0}},
    {"kepler", 4, kepler, {0.4, 0, 0, 2}, 20, 1, {0}},
};

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int gsl_field(double t, const double *x, double *dx, void *p)
{
    return ((const struct stiff_problem *)p)->rhs(NULL, t, x, dx) ? GSL_SUCCESS : GSL_EBADFUNC;
}

/* Central differences, as our integrator takes them where it is given none. */
static int gsl_slope(double t, const double *x, double *J, double *dt, void *p)
{
    const struct stiff_problem *s = p;
    double y[8], up[8], down[8];
    memcpy(y, x, (size_t)s->n * sizeof *y);
    for (int j = 0; j < s->n; j++) {
        double d = 6e-6 * fmax(fabs(x[j]), 1e-8);
        y[j] = x[j] + d;
        s->rhs(NULL, t, y, up);
        y[j] = x[j] - d;
        s->rhs(NULL, t, y, down);
        y[j] = x[j];
        for (int i = 0; i < s->n; i++)
            J[i * s->n + j] = (up[i] - down[i]) / (2 * d);
        dt[j] = 0;
    }
    return GSL_SUCCESS;
}

static bool run_gsl(const struct stiff_problem *s, const gsl_odeiv2_step_type *type, double tol, double *x)
{
    gsl_odeiv2_system system = {gsl_field, gsl_slope, (size_t)s->n, (void *)s};
    double scale[8], t = 0;
    for (int j = 0; j < s->n; j++)
        scale[j] = 1;
    gsl_odeiv2_driver *d = gsl_odeiv2_driver_alloc_scaled_new(&system, type, 1e-6, tol * s->atol, tol, 1, 0, scale);
    gsl_odeiv2_driver_set_nmax(d, 300000);
    memcpy(x, s->x, (size_t)s->n * sizeof *x);
    bool ok = gsl_odeiv2_driver_apply(d, &t, s->stop, x) == GSL_SUCCESS;
    gsl_odeiv2_driver_free(d);
    return ok;
}

static bool run_ours(const struct stiff_problem *s, const char *method, double tol, double *x)
{
    struct ode_problem p = {.n = s->n, .rhs = s->rhs};
    struct ode_start start = {0, s->x, 1, &s->stop};
    struct ode_options o = ode_options_default();
    o.rtol = tol;
    o.atol = tol * s->atol;
    o.method = method;
    struct ode_result r;
    bool ok = ode_solve(&p, &start, &o, &r, NULL) && r.count == 1;
    if (ok)
        memcpy(x, r.samples, (size_t)s->n * sizeof *x);
    ode_result_free(&r);
    return ok;
}

struct way { const char *name, *method; const gsl_odeiv2_step_type *type; };

/* Digits and seconds at a row of tolerances; then the seconds at `digits`, between two of
 * them on a logarithmic scale. Negative: not reached. */
static double seconds_at(const struct stiff_problem *s, const double *end, const struct way *w, double digits)
{
    double before = -1, seconds_before = 0, x[8];
    for (double e = 2; e < 14; e += 0.5) {
        double tol = pow(10, -e), seconds = 1e9, worst = 0;
        bool ok = true;
        for (int turn = 0; turn < 5 && ok; turn++) {
            double begin = now();
            ok = w->type ? run_gsl(s, w->type, tol, x) : run_ours(s, w->method, tol, x);
            seconds = fmin(seconds, now() - begin);
            if (now() - begin > 0.3)
                turn = 5;
        }
        if (!ok)
            continue;
        for (int j = 0; j < s->n; j++)
            worst = fmax(worst, fabs(x[j] - end[j]) / (fabs(end[j]) + s->atol));
        double got = -log10(fmax(worst, 1e-17));
        if (got >= digits) {
            if (before < 0 || got <= before)
                return seconds;
            double part = (digits - before) / (got - before);
            return exp((1 - part) * log(seconds_before) + part * log(seconds));
        }
        before = got;
        seconds_before = seconds;
    }
    return -1;
}

static void compare(const struct stiff_problem *s, const double *end, const struct way *peer, const char *ours)
{
    struct way own = {"auto", ours, NULL};
    printf("%-12s %-6s against %-6s:", s->name, ours ? ours : "auto", peer->name);
    for (double digits = 4; digits <= 12; digits += 2) {
        double a = seconds_at(s, end, &own, digits), b = seconds_at(s, end, peer, digits);
        if (a > 0 && b > 0)
            printf("  %2.0f digits %5.2f", digits, a / b);
        else
            printf("  %2.0f digits %5s", digits, a > 0 ? "only" : b > 0 ? "none" : "-");
    }
    printf("\n");
    fflush(stdout);
}

int main(void)
{
    gsl_set_error_handler_off();
    struct way rk8pd = {"rk8pd", NULL, gsl_odeiv2_step_rk8pd}, msbdf = {"msbdf", NULL, gsl_odeiv2_step_msbdf};
    puts("time of ours over time of the peer, at equal true error (only: the peer does not get there)");
    for (size_t i = 0; i < sizeof smooth / sizeof *smooth; i++) {
        double end[8];
        if (!run_ours(&smooth[i], "dop853", 1e-14, end))
            return 1;
        compare(&smooth[i], end, &rk8pd, NULL);
        compare(&smooth[i], end, &msbdf, NULL);
    }
    for (int i = 0; i < STIFF_PROBLEMS; i++) {
        compare(&stiff_problems[i], stiff_problems[i].end, &msbdf, NULL);
        compare(&stiff_problems[i], stiff_problems[i].end, &msbdf, "radau");
    }
    return 0;
}
