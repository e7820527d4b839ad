/* Signs that are followed from step to step: passages and touches, each told once, also where a step ends on one. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "guard_track.h"

/* A motion x = t, in steps from `from` on, h long; a function of it, whose value where a step begins may be another. */
struct motion {
    double (*function)(double t);
    double from, h, begin;     /* begin: what it is where the step begins; NAN: its value */
    double unsure;
    int told; double t[20]; int sense[20];
};

static void at(void *of, double s, double *g)
{
    const struct motion *m = of;
    *g = m->function(m->from + s * m->h);
}

static void end(void *of, bool last, double *g)
{
    const struct motion *m = of;
    at(of, last, g);
    if (!last && !isnan(m->begin))
        *g = m->begin;
}

static double doubt(void *of, int e, bool last)
{
    (void)e, (void)last;
    return ((const struct motion *)of)->unsure;
}

static void tell(struct motion *m, double s, int sense)
{
    CHECK(m->told < 20, "%d told", m->told);
    m->t[m->told] = m->from + s * m->h;
    m->sense[m->told++] = sense;
}

static void change(void *of, int e, double a, double ga, double b, double gb, int sense)
{
    struct motion *m = of;
    double g;
    const struct guard_way way = { .count = 1, .at = at, .of = m, .grain = 1e-15 };
    tell(m, b > 0 ? guard_root(&way, e, a, ga, b, gb, &g) : 0, sense);
}

static void touch(void *of, int e)
{
    (void)e;
    tell(of, 0, 0);
}

static double low(void *of, const struct guard_low *l)
{
    struct motion *m = of;
    if (fabs(l->d.value) > m->unsure)
        return -1;
    tell(m, l->d.at, 0);
    return m->unsure;
}

static void step(struct motion *m, struct guard_track *k)
{
    struct guard_table table;
    const struct guard_way way = { .count = 1, .at = at, .end = end, .of = m, .grain = 1e-15 };
    guard_table_init(&table, 1);
    guard_table_fill(&table, &way);
    guard_table_monotone(&table, &way);
    const struct guard_scan scan = { .table = &table, .way = &way, .of = m, .doubt = doubt, .change = change, .touch = touch, .low = low };
    guard_scan(&scan, 0, k);
    guard_table_clear(&table);
    m->from += m->h;
}

static double wave(double t) { return sin(7 * t) + 0.5; }
static double bowl(double t) { return (t - 0.3) * (t - 0.3); }
static double corner(double t) { return fabs(t - 1) - 1e-17; }
static double line(double t) { return t - 1; }
static double jump(double t) { return t < 1 ? -1 : 1; }

/* From 0 on, two steps of h = 1; begin: the value where the second begins. */
static struct motion two_steps(double (*function)(double), double begin, struct guard_track *k)
{
    struct motion m = { .function = function, .h = 1, .begin = NAN, .unsure = 1e-12 };
    double g = function(0);
    *k = (struct guard_track){ .sign = g > 0 ? 1 : -1, .before = g };
    step(&m, k);
    m.begin = begin;
    step(&m, k);
    return m;
}

static void passages(void)
{
    struct guard_track k;
    struct motion m = two_steps(wave, NAN, &k);
    int count = 0;
    for (int i = 0; i < 4; i++)
        for (int side = 0; side < 2; side++) {         /* sin 7 t = -1/2 */
            double t = ((side ? 11 : 7) * M_PI / 6 + 2 * M_PI * i) / 7;
            if (t < 2) {
                CHECK(count < m.told && fabs(m.t[count] - t) < 1e-12 && m.sense[count] == (side ? 1 : -1), "%g, sense %d, not %g", m.t[count], m.sense[count], t);
                count++;
            }
        }
    CHECK(count == m.told && k.sign == (wave(2) > 0 ? 1 : -1), "%d of %d", count, m.told);
}

static void touches(void)
{
    struct guard_track k;
    struct motion m = two_steps(bowl, NAN, &k);
    CHECK(m.told == 1 && m.sense[0] == 0 && fabs(m.t[0] - 0.3) < 1e-7 && !k.touched, "%d told, at %g", m.told, m.t[0]);
}

/* A step ends where the function is 0, or on either side of it by a rounding: one event. */
static void at_ends(void)
{
    struct guard_track k;
    static const double BEGIN[] = { -1e-17, 0, 1e-17 };
    for (int i = 0; i < 3; i++) {
        struct motion m = two_steps(line, BEGIN[i], &k);
        CHECK(m.told == 1 && m.sense[0] == 1 && fabs(m.t[0] - 1) < 1e-12 && k.sign == 1, "%g: %d told", BEGIN[i], m.told);
        m = two_steps(jump, i - 1, &k);
        CHECK(m.told == 1 && m.sense[0] == 1 && fabs(m.t[0] - 1) < 1e-12 && k.sign == 1, "a jump, %d: %d told", i - 1, m.told);
    }
    struct motion m = two_steps(corner, NAN, &k);
    CHECK(m.told <= 2 && m.told >= 1 && k.sign == 1, "%d told", m.told);
}

/* The arguments of guard_point: x and t. */
static double beside(void *ctx, int j, double by)
{
    const double *g = ctx;
    return *g + (j == 0 ? by : 0);
}

static double error_of(void *ctx, int j, enum guard_errors which)
{
    static const double BY[] = { [GUARD_ALLOWED] = 1e-6, [GUARD_TOLD] = 1e-15, [GUARD_FOUND] = 1e-12, [GUARD_PLACE] = 1e-3 };
    (void)ctx, (void)j;
    return BY[which];
}

static void starts(void)
{
    double g = 1e-9;
    struct guard_track k = { 0 };
    const struct guard_point p = { { beside, &g, 2 }, error_of, 0 };
    guard_track_start(&k, &p, 0, true);
    CHECK(k.sign == 1 && !k.carried, "small beside what is allowed, not beside what a start is found to: %d", k.sign);
    g = 1e-13;
    guard_track_start(&k, &p, 0, true);
    CHECK(k.sign == 0 && k.least >= 2e-6, "%d, %g", k.sign, k.least);
    guard_track_start(&k, &p, 0, false);
    CHECK(k.sign == 1, "what is told is known to roundings: %d", k.sign);
    g = 0;
    guard_track_start(&k, &p, -1, false);
    CHECK(k.sign == -1 && k.carried && k.least > 0, "the sign that it was left with: %d", k.sign);
}

int main(void)
{
    passages();
    touches();
    at_ends();
    starts();
    return CHECK_END();
}
