/* Functions of time and state along a step, on its dense output.
 *
 * Nodes are doubled until cubic interpolation predicts the values between them, so that several
 * zeros in one step are told apart, also of functions that vary faster than the solution. A change
 * of sign is located by regula falsi with halving (Illinois). */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "march.h"
#include "mem.h"
#include "warnings.h"

enum { FIRST_PARTS = 8, MOST_PARTS = SGA_MOST_TABLE_PARTS, PROBES = 11 };
#define RESOLVED 1e-3          /* of the range: how well values between nodes are predicted */
#define SAME 1e-7              /* of a step: extremes of several functions at one place make one node */
#define EDGE 1e-3              /* of a part: nodes beside the ends, for the slopes there */

void ode_table_init(struct ode_table *w, int count, int n, void (*function)(void *, double, const double *, double *))
{
    size_t e = (size_t)count;
    *w = (struct ode_table){ .count = count, .function = function };
    w->room = MOST_PARTS + 3;
    w->theta = sga_malloc((size_t)w->room * sizeof *w->theta);
    w->value = sga_malloc((size_t)w->room * e * sizeof *w->value);
    w->g = sga_malloc((3 * e + (size_t)n + 1) * sizeof *w->g);
    w->low = w->g + e;
    w->high = w->low + e;
    w->x = w->high + e;
}

void ode_table_clear(struct ode_table *w)
{
    free(w->theta);
    free(w->value);
    free(w->g);
    free(w->turn);
    free(w->quiet);
}

static double *values(struct ode_march *m, struct ode_table *w, double t, const double *x)
{
    w->function(m->p->ctx, t, x, w->g);
    return w->g;
}

double *ode_table_at(struct ode_march *m, struct ode_table *w, double theta)
{
    m->method->dense_at(m->state, &m->step, theta, w->x);
    return values(m, w, m->t + (theta * m->step.h + m->t_low), w->x);
}

static void put(struct ode_table *w, int node, const double *g)
{
    size_t e = (size_t)w->count;
    memcpy(w->value + (size_t)node * e, g, e * sizeof *g);
}

/* The cubic through four values in equal distances, at u between the second (0) and the third (1). */
static double cubic(double a, double b, double c, double d, double u)
{
    return b * (u + 1) * (u - 1) * (u - 2) / 2 - c * u * (u + 1) * (u - 2) / 2 + d * u * (u + 1) * (u - 1) / 6
           - a * u * (u - 1) * (u - 2) / 6;
}

static void find_ranges(struct ode_table *w, int parts)
{
    size_t count = (size_t)w->count;
    for (size_t e = 0; e < count; e++) {
        w->low[e] = INFINITY;
        w->high[e] = -INFINITY;
    }
    for (size_t i = 0; i <= (size_t)parts; i++)
        for (size_t e = 0; e < count; e++) {
            double v = w->value[i * count + e];
            w->low[e] = v < w->low[e] ? v : w->low[e];
            w->high[e] = v > w->high[e] ? v : w->high[e];
        }
}

/* How far values between the nodes are from the cubic through the nodes, in irregular places,
 * because a wave whose length divides the distance of the nodes would be taken for a slow one;
 * and whether that is little for all functions. Ends are left out: they are projected. */
static bool predicted(struct ode_march *m, struct ode_table *w, int parts)
{
    size_t count = (size_t)w->count;
    find_ranges(w, parts);
    for (int k = 1; k <= PROBES; k++) {
        double at = 2 + (parts - 4) * fmod(k * 0.61803398874989485, 1), whole = floor(at);
        const double *g = ode_table_at(m, w, at / parts), *v = w->value + ((size_t)whole - 1) * count;
        for (size_t e = 0; e < count; e++) {
            double low = w->low[e], high = w->high[e];
            double miss = fabs(g[e] - cubic(v[e], v[count + e], v[2 * count + e], v[3 * count + e], at - whole));
            if (miss > RESOLVED * (high - low) + 1e-13 * fmax(fabs(low), fabs(high)))
                return false;
        }
    }
    return true;
}

void ode_table_fill(struct ode_march *m, struct ode_table *w)
{
    size_t row = (size_t)w->count * sizeof *w->value;
    int parts = FIRST_PARTS;
    bool seen;
    for (int i = 1; i < parts; i++)
        put(w, i, ode_table_at(m, w, (double)i / parts));
    put(w, 0, values(m, w, m->t, m->x));
    put(w, parts, values(m, w, m->t1, m->x1));
    do {
        for (int i = parts; i > 0; i--)
            memcpy(w->value + 2 * (size_t)i * (size_t)w->count, w->value + (size_t)i * (size_t)w->count, row);
        parts *= 2;
        for (int i = 1; i < parts; i += 2)
            put(w, i, ode_table_at(m, w, (double)i / parts));
        seen = predicted(m, w, parts);
    } while (parts < MOST_PARTS && !seen);
    if (!seen)
        sga_limit_met(m->o->budget, SGA_LIMIT_TABLE_PARTS);
    memmove(w->value + 2 * (size_t)w->count, w->value + (size_t)w->count, (size_t)(parts - 1) * row);
    w->nodes = parts + 3;
    for (int i = 1; i < parts; i++)
        w->theta[i + 1] = (double)i / parts;
    w->theta[0] = 0;
    w->theta[1] = EDGE / parts;
    w->theta[parts + 1] = 1 - EDGE / parts;
    w->theta[parts + 2] = 1;
    put(w, 1, ode_table_at(m, w, w->theta[1]));
    put(w, parts + 1, ode_table_at(m, w, w->theta[parts + 1]));
    put(w, parts + 2, values(m, w, m->t1, m->x1));
}

/* One more node between two that are there. */
static void insert(struct ode_march *m, struct ode_table *w, int at, double theta)
{
    size_t count = (size_t)w->count, behind = (size_t)(w->nodes - at);
    assert(at > 0 && w->theta[at - 1] < theta && theta < w->theta[at]);
    if (w->nodes == w->room) {
        w->room *= 2;
        w->theta = sga_realloc(w->theta, (size_t)w->room * sizeof *w->theta);
        w->value = sga_realloc(w->value, (size_t)w->room * count * sizeof *w->value);
    }
    memmove(w->theta + at + 1, w->theta + at, behind * sizeof *w->theta);
    memmove(w->value + ((size_t)at + 1) * count, w->value + (size_t)at * count, behind * count * sizeof *w->value);
    w->theta[at] = theta;
    put(w, at, ode_table_at(m, w, theta));
    w->nodes++;
}

void ode_table_monotone(struct ode_march *m, struct ode_table *w)
{
    ode_table_turns(m, w);
    int at = 2;
    for (int k = 0; k < w->turns; k++) {
        double theta = w->turn[k];
        while (at < w->nodes - 1 && w->theta[at] < theta)
            at++;
        if (theta - w->theta[at - 1] > SAME && w->theta[at] - theta > SAME && w->theta[at - 1] > 0 && w->theta[at] < 1)
            insert(m, w, at, theta);
    }
    assert(ode_table_sane(w));
}

double ode_table_root(struct ode_march *m, struct ode_table *w, int e, double a, double ga, double b, double gb)
{
    double least = 2 * DBL_EPSILON * fmax(fabs(m->t), fabs(m->t1)) / fabs(m->step.h);
    assert(0 <= a && a <= b && b <= 1 && !(ga * gb > 0));
    for (int k = 0; k < 200 && b - a > fmax(least, DBL_EPSILON); k++) {
        double s = a + (b - a) * (ga / (ga - gb));
        if (!(s > a && s < b) || k % 4 == 3)
            s = 0.5 * (a + b);
        double g = ode_table_at(m, w, s)[e];
        if (g == 0)
            return s;
        if ((g > 0) == (ga > 0)) {
            a = s;
            ga = g;
            gb *= 0.5;
        } else {
            b = s;
            gb = g;
            ga *= 0.5;
        }
    }
    return b;
}
