/* Events against zeros known in closed form: several in a step, both directions of time,
 * touches and passages as deep as the tolerance and deeper, stops. */
#include <math.h>
#include <stdlib.h>

#include "check.h"
#include "ode.h"

enum { MOST = 4000 };
#define PI 3.14159265358979323846

struct wave { double rate, phase, level; };      /* sin(rate t + phase) - level */

static bool turn(void *c, double t, const double *x, double *dx)
{
    (void)c; (void)t;
    dx[0] = x[1];
    dx[1] = -x[0];
    return true;
}
static bool lazy(void *c, double t, const double *x, double *dx)     /* steps as long as they may be */
{
    (void)c; (void)t; (void)x;
    dx[0] = 1;
    dx[1] = 0;
    return true;
}
static void height(void *c, double t, const double *x, double *g)
{
    (void)t;
    *g = x[0] - ((const struct wave *)c)->level;
}
static void wave(void *c, double t, const double *x, double *g)
{
    const struct wave *w = c;
    (void)t;
    *g = sin(w->rate * x[0] + w->phase) - w->level;
}

/* The zeros of sin(rate t + phase) - level in a < t < b, ascending, and which way. */
static int zeros(const struct wave *w, double a, double b, double *t, int *way)
{
    int n = 0;
    double up = asin(w->level), down = PI - up;
    long k = (long)floor((w->rate * a + w->phase) / (2 * PI)) - 1;
    for (; n < MOST; k++) {
        double at[] = {(up + 2 * PI * (double)k - w->phase) / w->rate, (down + 2 * PI * (double)k - w->phase) / w->rate};
        for (int i = 0; i < 2; i++)
            if (at[i] > a && at[i] < b) {
                t[n] = at[i];
                way[n++] = i ? -1 : 1;
            }
        if (at[0] > b)
            return n;
    }
    return n;
}

static void compare(const char *what, struct wave *w, bool fast, const char *method, int direction, double from, double to)
{
    static double known[MOST];
    static int way[MOST];
    struct ode_event spec = {direction, false};
    struct ode_problem p = {.n = 2, .ctx = w, .rhs = fast ? lazy : turn, .events = 1, .event_spec = &spec, .event = fast ? wave : height};
    double x[] = {fast ? from : sin(from), fast ? 0 : cos(from)}, t[] = {to};
    struct ode_start start = {from, x, 1, t};
    struct ode_options o = ode_options_default();
    struct ode_result r;
    o.method = method;
    o.estimate_global_error = true;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.end.reason == ODE_NONE);
    int n = zeros(w, fmin(from, to), fmax(from, to), known, way), at = 0;
    for (int k = 0; k < n; k++) {
        int i = to < from ? n - 1 - k : k;
        if (direction && way[i] != direction)
            continue;
        if (at < r.happened) {
            const struct ode_happening *h = r.happening + at;
            CHECK(fabs(h->t - known[i]) <= fmin(1e-6, 2 * h->error + 1e-13), "%s: %g off by %g, estimated %g", what, known[i],
                  h->t - known[i], h->error);
            CHECK(h->crossing == way[i], "%s: way", what);
            CHECK(fabs(r.happened_x[2 * at] - (fast ? h->t : sin(h->t))) < 1e-7, "%s: state", what);
        }
        at++;
    }
    CHECK(at == r.happened, "%s: %d events of %d", what, r.happened, at);
    ode_result_free(&r);
}

static void test_closed(void)
{
    srand(7);
    for (int k = 0; k < 40; k++) {
        struct wave slow = {1, 0, 1.9 * rand() / RAND_MAX - 0.95};
        struct wave fast = {1 + 60.0 * rand() / RAND_MAX, 3.0 * rand() / RAND_MAX, slow.level};
        const char *method = k % 4 == 3 ? "radau" : "dop853";
        double from = 0.3 + 0.1 * k, to = k % 2 ? from - 11 : from + 17;
        if (fabs(sin(from) - slow.level) > 1e-3)
            compare("slow", &slow, false, method, k % 3 - 1, from, to);
        if (fabs(sin(fast.rate * from + fast.phase) - fast.level) > 1e-3)
            compare("fast", &fast, true, method, k % 3 - 1, from, to);
    }
}

/* sin t from 0 to 6 against levels near 1. */
static int near_top(double level, int direction, bool stop, struct ode_result *r)
{
    struct wave w = {1, 0, level};
    struct ode_event spec = {direction, stop};
    struct ode_problem p = {.n = 2, .ctx = &w, .rhs = turn, .events = 1, .event_spec = &spec, .event = height};
    double x[] = {0, 1}, t[] = {1, 1.5, 2, 6};
    struct ode_start start = {0, x, 4, t};
    struct ode_options o = ode_options_default();
    o.estimate_global_error = o.refine = true;
    CHECK(ode_solve(&p, &start, &o, r, NULL));
    return r->happened;
}

static void test_grazing(void)
{
    struct ode_result r;
    CHECK(near_top(1, 0, false, &r) == 1 && r.happening[0].crossing == 0 && fabs(r.happening[0].t - PI / 2) < 1e-4);
    ode_result_free(&r);
    CHECK(near_top(1, 1, false, &r) == 0);
    ode_result_free(&r);
    CHECK(near_top(1 + 1e-6, 0, false, &r) == 0);
    ode_result_free(&r);
    CHECK(near_top(1 - 1e-6, 0, false, &r) == 2 && fabs(r.happening[0].t - asin(1 - 1e-6)) < 1e-7 && r.happening[1].crossing == -1);
    ode_result_free(&r);
    CHECK(near_top(1 - 1e-6, -1, true, &r) == 1 && r.end.reason == ODE_EVENT && r.end.t == r.happening[0].t && r.count == 2);
    ode_result_free(&r);
    CHECK(near_top(0, 0, false, &r) == 1 && fabs(r.happening[0].t - PI) < 1e-9, "not the start");
    ode_result_free(&r);
}

/* A stop exactly at a sample, and the samples before it. */
static void test_stop(void)
{
    struct ode_result r;
    CHECK(near_top(0.5, -1, true, &r) == 1 && r.end.reason == ODE_EVENT && r.count == 3 && r.shortfall == NULL, "%d", r.count);
    CHECK(fabs(r.end.t - 5 * PI / 6) < 1e-9 && r.max_error < 1e-8, "%g %g", r.end.t, r.max_error);
    ode_result_free(&r);
    CHECK(near_top(sin(2), -1, true, &r) == 1 && fabs(r.end.t - 2) < 1e-9 && (r.count == 2 || r.count == 3));
    CHECK(r.shortfall == NULL && r.max_error < 1e-8, "%g", r.max_error);
    ode_result_free(&r);
}

/* (x - r_0)(x - r_1)... along x = t: how many events, and the least distance of each from its zero. */
struct roots { int count; double at[6]; };
static void product(void *c, double t, const double *x, double *g)
{
    const struct roots *r = c;
    (void)t;
    *g = 1;
    for (int k = 0; k < r->count; k++)
        *g *= x[0] - r->at[k];
}

/* A zero that stands twice is one touch; they are ascending. */
static void test_products(void)
{
    static struct roots sets[] = { { 4, { 0.25, 0.5, 0.7, 0.7001 } }, { 4, { 0.25, 0.5, 0.7, 0.7 } }, { 6, { 0.11, 0.1101, 0.4, 0.4, 0.9, 0.9003 } },
                                   { 5, { 0.2, 0.2, 0.31, 0.77, 0.77 } }, { 3, { 0.6, 0.6005, 0.601 } }, { 2, { 0.5, 0.5 } } };
    const char *methods[] = { "dop853", "tsit5", "radau" };
    for (int k = 0; k < 18; k++) {
        struct roots *w = sets + k % 6;
        struct ode_event spec = { 0, false };
        struct ode_problem p = { .n = 2, .ctx = w, .rhs = lazy, .events = 1, .event_spec = &spec, .event = product };
        double x[] = { 0, 0 }, t[] = { 1 };
        struct ode_start start = { 0, x, 1, t };
        struct ode_options o = ode_options_default();
        struct ode_result r;
        int at = 0;
        o.method = methods[k / 6];
        CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.end.reason == ODE_NONE);
        for (int i = 0; i < w->count; i++, at++) {
            bool twice = i + 1 < w->count && w->at[i + 1] == w->at[i];
            CHECK(at < r.happened && fabs(r.happening[at].t - w->at[i]) < 1e-7, "%s, set %d: zero %g", o.method, k % 6, w->at[i]);
            CHECK(at >= r.happened || (r.happening[at].crossing == 0) == twice, "%s, set %d: kind of %g", o.method, k % 6, w->at[i]);
            i += twice;
        }
        CHECK(at == r.happened, "%s, set %d: %d events of %d", o.method, k % 6, r.happened, at);
        ode_result_free(&r);
    }
}

int main(void)
{
    test_closed();
    test_products();
    test_grazing();
    test_stop();
    return CHECK_END();
}
