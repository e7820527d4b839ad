/* Switches of a field against solutions in closed form: passed once and often, touched, slid along, at the start, where the
 * field held on one side has no values beyond, several at a time, in both directions of time. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "ode.h"

#define PI 3.14159265358979323846

/* A field with up to two switches: sign k of a switch is s[k], the held side or that of g. */
struct field {
    int n, switches;
    void (*g)(double t, const double *x, double *g);
    bool (*f)(double t, const double *x, const double *s, double *dx);
    signed char side[2];
};

static void surfaces(void *c, double t, const double *x, double *g) { ((struct field *)c)->g(t, x, g); }
static void hold(void *c, const signed char *side)
{
    struct field *f = c;
    for (int k = 0; k < f->switches; k++)
        f->side[k] = side ? side[k] : 0;
}
static bool rhs(void *c, double t, const double *x, double *dx)
{
    struct field *f = c;
    double g[2], s[2];
    f->g(t, x, g);
    for (int k = 0; k < f->switches; k++)
        s[k] = f->side[k] ? f->side[k] : (g[k] > 0) - (g[k] < 0);
    return f->f(t, x, s, dx);
}

static void g_first(double t, const double *x, double *g) { (void)t; g[0] = x[0]; }
static void g_both(double t, const double *x, double *g) { (void)t; g[0] = x[0]; g[1] = x[1]; }
static void g_wave(double t, const double *x, double *g) { (void)x; g[0] = sin(7 * t); }
static void g_moving(double t, const double *x, double *g) { g[0] = x[0] - t; g[1] = 2 * (x[0] - t); }

static bool parabolas(double t, const double *x, const double *s, double *dx)
{
    (void)t;
    dx[0] = x[1];
    dx[1] = -s[0];
    return true;
}
/* x'' = -sign(x) from x = 1 at rest. */
static double parabola(double t)
{
    double q = sqrt(2), n = floor((fabs(t) + q) / (2 * q)), u = fabs(t) + q - 2 * q * n;
    return (q * u - u * u / 2) * (fmod(n, 2) ? -1 : 1);
}
static bool two_springs(double t, const double *x, const double *s, double *dx)      /* v' = -4x for x > 0, else -x */
{
    (void)t;
    dx[0] = x[1];
    dx[1] = -(2.5 + 1.5 * s[0]) * x[0];
    return true;
}
static double two_springs_at(double t)
{
    double u = fmod(t, 1.5 * PI);
    return u < PI / 2 ? sin(2 * u) / 2 : -sin(u - PI / 2);
}
static bool rectified(double t, const double *x, const double *s, double *dx)
{
    (void)x;
    dx[0] = s[0] * sin(7 * t);
    return true;
}
static double rectified_at(double t)
{
    double n = floor(7 * t / PI);
    return (2 * n + 1 - (fmod(n, 2) ? -1 : 1) * cos(7 * t)) / 7;
}
static bool twice(double t, const double *x, const double *s, double *dx)     /* two switches at one place */
{
    (void)t; (void)x;
    dx[0] = 0.25 * (2 - s[0]) * (2 + s[1]);
    return true;
}
static double twice_at(double t) { return t < 2 ? 0.5 + 0.75 * t : 2 + 0.75 * (t - 2); }
/* x' = -50 max(x, 0) + max(0, sin 5t)^2: comes to rest on the switch after each pulse, and leaves it slowly with the next. */
static void g_drain(double t, const double *x, double *g) { g[0] = x[0]; g[1] = sin(5 * t); }
static bool drain(double t, const double *x, const double *s, double *dx)
{
    dx[0] = (s[0] > 0 ? -50 * x[0] : 0) + (s[1] > 0 ? sin(5 * t) * sin(5 * t) : 0);
    return true;
}
static double drain_at(double t)
{
    double sum = 0;
    for (double a = 0; a < t; a += 0.4 * PI) {
        double b = fmin(t, a + 0.2 * PI), left = exp(-50 * (t - a)), right = exp(-50 * (t - b));
        sum += (right - left) / 100 - (right * (50 * cos(10 * b) + 10 * sin(10 * b)) - 50 * left) / 5200;
    }
    return sum;
}
static bool root(double t, const double *x, const double *s, double *dx)      /* sqrt(abs(x)) + 1: held, no values beyond */
{
    (void)t;
    if (s[0] * x[0] < 0)
        return false;
    dx[0] = sqrt(fabs(x[0])) + 1;
    return true;
}
static bool slide(double t, const double *x, const double *s, double *dx)
{
    (void)t; (void)x;
    dx[0] = 0.25 - s[0];
    return true;
}
static bool rest(double t, const double *x, const double *s, double *dx)
{
    (void)t; (void)x;
    dx[0] = -s[0];
    return true;
}
static bool graze(double t, const double *x, const double *s, double *dx)      /* x = (t-1)^2 touches 0 */
{
    dx[0] = 2 * (t - 1);
    dx[1] = s[0] * x[0];
    return true;
}
static bool dry(double t, const double *x, const double *s, double *dx)        /* infinitely many turns in a finite time */
{
    (void)t;
    dx[0] = x[1];
    dx[1] = -s[0] - 0.5 * s[1];
    return true;
}

static const char *const methods[] = {"tsit5", "dop853", "radau"};
enum { METHODS = 3, SAMPLES = 24 };

static struct ode_result run(struct field *f, const char *method, double tol, double from, double to, const double *x)
{
    double t[SAMPLES];
    struct ode_problem p = {.n = f->n, .ctx = f, .rhs = rhs, .switches = f->switches, .switching = surfaces, .hold = hold};
    struct ode_start start = {from, x, SAMPLES, t};
    struct ode_options o = ode_options_default();
    struct ode_result r;
    for (int k = 0; k < SAMPLES; k++)
        t[k] = from + (to - from) * (k + 1) / SAMPLES;
    o.method = method;
    o.rtol = o.atol = tol;
    o.estimate_global_error = true;
    CHECK(ode_solve(&p, &start, &o, &r, NULL));
    return r;
}

static int samples, held;

static void against(struct field f, double from, double to, const double *x, double (*exact)(double), int least_kinks)
{
    for (int m = 0; m < METHODS; m++)
        for (double tol = 1e-4; tol > 1e-11; tol /= 100) {
            struct ode_result r = run(&f, methods[m], tol, from, to, x);
            CHECK(r.end.reason == ODE_NONE, "%s %s", methods[m], r.end.detail);
            CHECK(r.stats.kinks >= least_kinks && r.stats.kinks <= least_kinks + 2, "%s: %ld turns", methods[m], r.stats.kinks);
            for (int k = 0; k < r.count; k++) {
                double e = fabs(r.samples[(size_t)k * (size_t)f.n] - exact(from + (to - from) * (k + 1) / SAMPLES));
                samples++;
                held += e <= r.error[k] + 1e-14;
                CHECK(e <= 300 * tol, "%s at %g: %g", methods[m], tol, e);
            }
            ode_result_free(&r);
        }
}

static void test_closed(void)
{
    double rest_at_1[] = {1, 0}, start[] = {0, 1}, none[] = {0}, half[] = {0.5};
    against((struct field){2, 1, g_first, parabolas, {0}}, 0, 20, rest_at_1, parabola, 7);
    against((struct field){2, 1, g_first, parabolas, {0}}, 0, -20, rest_at_1, parabola, 7);
    against((struct field){2, 1, g_first, two_springs, {0}}, 0, 14, start, two_springs_at, 5);
    against((struct field){1, 1, g_wave, rectified, {0}}, 0, 5, none, rectified_at, 11);
    against((struct field){1, 2, g_moving, twice, {0}}, 0, 5, half, twice_at, 2);
    against((struct field){1, 2, g_drain, drain, {0}}, 0, 6, none, drain_at, 9);
    CHECK(held >= 0.95 * samples, "%d of %d estimates hold", held, samples);
}

static void test_no_values_beyond(void)
{
    double x[] = {-1}, exact[] = {0};
    struct field f = {1, 1, g_first, root, {0}};
    for (int m = 0; m < METHODS; m++) {
        struct ode_result r = run(&f, methods[m], 1e-8, 0, 3, x);
        CHECK(r.end.reason == ODE_NONE && r.count == SAMPLES, "%s: %s", methods[m], r.end.detail);
        /* 2 (u - log(1 + u)), u = sqrt|x|, is the time on either side of 0 */
        double low = 0, high = 4;
        for (int k = 0; k < 60; k++) {
            double u = 0.5 * (low + high), t = 2 * (1 - log(2)) + 2 * (u - log(1 + u));
            *(t < 3 ? &low : &high) = u;
        }
        exact[0] = low * low;
        CHECK(fabs(r.samples[SAMPLES - 1] - exact[0]) < 1e-6, "%s: %g, not %g", methods[m], r.samples[SAMPLES - 1], exact[0]);
        ode_result_free(&r);
    }
}

static void test_endings(void)
{
    double one[] = {1}, zero[] = {0}, pair[] = {1, 0};
    struct field sliding = {1, 1, g_first, slide, {0}}, resting = {1, 1, g_first, rest, {0}}, zeno = {2, 2, g_both, dry, {0}};
    struct field touching = {2, 1, g_first, graze, {0}};
    for (int m = 0; m < METHODS; m++) {
        struct ode_result r = run(&sliding, methods[m], 1e-8, 0, 3, one);
        CHECK(r.end.reason == ODE_NOT_SMOOTH && fabs(r.end.t - 4.0 / 3) < 1e-9 && strstr(r.end.detail, "slide"), "%s: %.12g %s", methods[m],
              r.end.t, r.end.detail);
        ode_result_free(&r);
        r = run(&resting, methods[m], 1e-8, 0, 3, zero);      /* an equilibrium as it stands */
        CHECK(r.end.reason == ODE_NONE && r.samples[SAMPLES - 1] == 0);
        ode_result_free(&r);
        r = run(&zeno, methods[m], 1e-8, 0, 20, pair);
        /* from x = 1 at rest to -1/3 at rest in 2 + 2/3, and times go with the root of the size */
        double t = 8.0 / 3 / (1 - 1 / sqrt(3));
        CHECK(r.end.reason == ODE_NOT_SMOOTH && r.stats.steps < 3000, "%s", r.end.detail);
        CHECK(fabs(r.end.t - t) < 1e-3, "%s: %.12g", methods[m], r.end.t);
        ode_result_free(&r);
        r = run(&touching, methods[m], 1e-8, 0, 2, pair);
        CHECK(r.end.reason == ODE_NONE && fabs(r.samples[2 * SAMPLES - 1] - 2.0 / 3) < 1e-9, "%s: %g", methods[m], r.samples[2 * SAMPLES - 1]);
        ode_result_free(&r);
    }
}

int main(void)
{
    test_closed();
    test_no_values_beyond();
    test_endings();
    return CHECK_END();
}
