/* Tables of functions along a way against zeros, touches and extremes known in closed form: products and clusters, waves, functions without a value somewhere. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "check.h"
#include "guard.h"

enum { MOST = 8, FUNCTIONS = 3 };

struct products { int zeros; double zero[FUNCTIONS][MOST]; };

static void product(void *of, double s, double *g)
{
    const struct products *p = of;
    for (int k = 0; k < FUNCTIONS; k++) {
        g[k] = 1;
        for (int i = 0; i < p->zeros; i++)
            g[k] *= s - p->zero[k][i];
    }
}

static double any(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

static int ascending(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

/* Zeros in clusters of any width: each is a change of sign between two nodes, and is found where it is. */
static void clusters(void)
{
    uint64_t random = check_seed(20261129);
    for (int run = 0; run < check_scale(400); run++) {
        struct products p = { .zeros = 2 + run % (MOST - 2) };
        double width = pow(10, -4 * any(&random));
        for (int k = 0; k < FUNCTIONS; k++) {
            double at = 0.1 + 0.7 * any(&random);
            for (int i = 0; i < p.zeros; i++)
                p.zero[k][i] = at + 0.19 * width * (i + 0.7 * any(&random)) / p.zeros;
            qsort(p.zero[k], (size_t)p.zeros, sizeof(double), ascending);
        }
        struct guard_way way = { .count = FUNCTIONS, .at = product, .of = &p, .grain = 1e-15 };
        struct guard_table t;
        guard_table_init(&t, FUNCTIONS);
        guard_table_fill(&t, &way);
        guard_table_monotone(&t, &way);
        CHECK(guard_table_sane(&t));
        for (int k = 0; k < FUNCTIONS; k++) {
            int found = 0;
            bool near = true;
            for (int i = 0; i + 1 < t.nodes; i++) {
                double a = guard_value(&t, i, k), b = guard_value(&t, i + 1, k);
                if (!(a * b < 0))
                    continue;
                double s = guard_root(&way, k, t.theta[i], a, t.theta[i + 1], b, t.g);
                near &= found < p.zeros && fabs(s - p.zero[k][found < p.zeros ? found : 0]) < 1e-12;
                found++;
            }
            CHECK(near, "run %d function %d", run, k);
            CHECK(found == p.zeros, "run %d function %d: %d of %d", run, k, found, p.zeros);
        }
        guard_table_clear(&t);
    }
}

/* |g| that comes near 0 and does not touch it: the node is where it is least. */
struct bump { double at, least, power; };
static void bump(void *of, double s, double *g)
{
    const struct bump *b = of;
    *g = b->least + pow(fabs(s - b->at), b->power);
}

static void extremes(void)
{
    for (int run = 0; run < 50; run++) {
        struct bump b = { .at = 0.013 + 0.0193 * run, .least = pow(10, -run % 9), .power = 2 + 2 * (run % 2) };
        struct guard_way way = { .count = 1, .at = bump, .of = &b, .grain = 1e-15 };
        struct guard_table t;
        guard_table_init(&t, 1);
        guard_table_fill(&t, &way);
        guard_table_monotone(&t, &way);
        double least = INFINITY;
        for (int i = 0; i < t.nodes; i++)
            least = fmin(least, guard_value(&t, i, 0));
        if (b.least < 0.1)         /* far from 0 it need not be known */
            CHECK(least - b.least <= 1e-12 && least >= b.least, "run %d: %.3g beside %.3g", run, least, b.least);
        double flat = pow(1e-15 * (1 + b.least), 1 / b.power) * 4;
        int at = 1;
        while (at + 2 < t.nodes && t.theta[at] < b.at)
            at++;
        struct guard_dip d = { .a = 0, .at = t.theta[at], .b = 1, .value = guard_value(&t, at, 0), .function = 0, .sense = 1 };
        guard_least(&way, &d, 1e-9, t.g);
        CHECK(d.value <= guard_value(&t, at, 0) && fabs(d.at - b.at) < flat && d.b - d.a <= 2e-9, "run %d: %.9g, not %.9g", run, d.at, b.at);
        guard_table_clear(&t);
    }
}

/* An extreme of higher order just beyond 0: two zeros. */
static void flat_dips(void)
{
    for (int run = 0; run < 60; run++) {
        struct bump b = { .at = 0.15 + 0.0116 * run, .least = -pow(10, -6 - run % 7), .power = 2 + 2 * (run % 3) };
        struct guard_way way = { .count = 1, .at = bump, .of = &b, .grain = 1e-15 };
        struct guard_table t;
        guard_table_init(&t, 1);
        guard_table_fill(&t, &way);
        guard_table_monotone(&t, &way);
        int found = 0;
        for (int i = 0; i + 1 < t.nodes; i++)
            found += guard_value(&t, i, 0) * guard_value(&t, i + 1, 0) < 0;
        CHECK(found == 2, "run %d: %d", run, found);
        guard_table_clear(&t);
    }
}

/* A dip beyond 0 in a function that cancels: its values are known to roundings of 1. */
static long evaluations;
static void cancelling(void *of, double s, double *g)
{
    const struct bump *b = of;
    volatile double one = 1 - (pow(s - b->at, 2) + b->least);
    evaluations++;
    *g = 1 - one;
}

static void noise(void)
{
    for (int run = 0; run < 60; run++) {
        struct bump b = { .at = 0.15 + 0.0116 * run, .least = -pow(10, -6 - run % 7) };
        struct guard_way way = { .count = 1, .at = cancelling, .of = &b, .grain = 1e-15 };
        struct guard_table t;
        evaluations = 0;
        guard_table_init(&t, 1);
        guard_table_fill(&t, &way);
        guard_table_monotone(&t, &way);
        bool beyond = false;
        for (int i = 0; i < t.nodes; i++)
            beyond |= guard_value(&t, i, 0) < 0.5 * b.least;
        CHECK(beyond, "run %d", run);
        CHECK(evaluations < 500, "run %d: %ld evaluations", run, evaluations);
        guard_table_clear(&t);
    }
}

/* No value before `from`. */
static void root_of(void *of, double s, double *g) { *g = s < *(double *)of ? NAN : sin(40 * s) - 0.3; }

static void partly_undefined(void)
{
    double from = 0.31;
    struct guard_way way = { .count = 1, .at = root_of, .of = &from, .grain = 1e-15 };
    struct guard_table t;
    guard_table_init(&t, 1);
    guard_table_fill(&t, &way);
    guard_table_monotone(&t, &way);
    int found = 0, expected = 0;
    for (int k = 0; k < 20; k++) {
        double up = (asin(0.3) + 2 * M_PI * k) / 40, down = (M_PI - asin(0.3) + 2 * M_PI * k) / 40;
        expected += (up > from && up < 1) + (down > from && down < 1);
    }
    for (int i = 0; i + 1 < t.nodes; i++)
        found += guard_value(&t, i, 0) * guard_value(&t, i + 1, 0) < 0;
    CHECK(found == expected, "%d of %d", found, expected);
    guard_table_clear(&t);
}

/* Where the way begins and ends the points may lie beside it. */
static void constant(void *of, double s, double *g) { (void)of; *g = 1 + 0 * s; }
static void beside(void *of, bool end, double *g) { (void)of; *g = end ? -1 : -2; }

static void ends(void)
{
    struct guard_way way = { .count = 1, .at = constant, .end = beside, .grain = 1e-15 };
    struct guard_table t;
    guard_table_init(&t, 1);
    guard_table_fill(&t, &way);
    guard_table_monotone(&t, &way);
    CHECK(guard_value(&t, 0, 0) == -2 && guard_value(&t, t.nodes - 1, 0) == -1 && guard_value(&t, 1, 0) == 1);
    guard_table_clear(&t);
}

int main(void)
{
    clusters();
    extremes();
    flat_dips();
    noise();
    partly_undefined();
    ends();
    return CHECK_END();
}
