/* Nodes on a way: they are doubled until cubic interpolation predicts the values between them, so that several zeros are told apart, also of
 * functions that vary faster than the way; then extremes are added (guard_turns.c). */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "guard.h"
#include "mem.h"
#include "warnings.h"

enum { FIRST_PARTS = 8, MOST_PARTS = SGA_MOST_TABLE_PARTS, PROBES = 11 };
#define RESOLVED 1e-3          /* of the range: how well values between nodes are predicted */
#define FAR 2.0                /* times its changes from 0: what a function does then is of no matter */
#define ROUNDINGS 8.0          /* of the place, in a value */
#define SAME 1e-7              /* of a step: extremes of several functions at one place make one node */
#define EDGE 1e-3              /* of a part: nodes beside the ends, for the slopes there */

void guard_table_init(struct guard_table *t, int count)
{
    size_t e = (size_t)count;
    *t = (struct guard_table){ .count = count };
    t->g = sga_malloc((5 * e + 1) * sizeof *t->g);
    t->low = t->g + e;
    t->high = t->low + e;
    t->noise = t->high + e;
    t->tail = t->noise + e;
}

void guard_table_clear(struct guard_table *t)
{
    free(t->theta);
    free(t->value);
    free(t->g);
    free(t->turn);
    free(t->quiet);
}

static void reserve(struct guard_table *t, int nodes)
{
    if (nodes <= t->room)
        return;
    t->room = nodes;
    t->theta = sga_realloc(t->theta, (size_t)nodes * sizeof *t->theta);
    t->value = sga_realloc(t->value, ((size_t)nodes * (size_t)t->count + 1) * sizeof *t->value);
}

static const double *values(struct guard_table *t, const struct guard_way *way, double s)
{
    way->at(way->of, s, t->g);
    return t->g;
}

static const double *end_values(struct guard_table *t, const struct guard_way *way, bool end)
{
    if (!way->end)
        return values(t, way, end);
    way->end(way->of, end, t->g);
    return t->g;
}

static void put(struct guard_table *t, int node, const double *g)
{
    size_t e = (size_t)t->count;
    memcpy(t->value + (size_t)node * e, g, e * sizeof *g);
}

/* The cubic through four values in equal distances, at u between the second (0) and the third (1). */
static double cubic(double a, double b, double c, double d, double u)
{
    return b * (u + 1) * (u - 1) * (u - 2) / 2 - c * u * (u + 1) * (u - 2) / 2 + d * u * (u + 1) * (u - 1) / 6
           - a * u * (u - 1) * (u - 2) / 6;
}

static void find_ranges(struct guard_table *t, int parts)
{
    size_t count = (size_t)t->count;
    for (size_t e = 0; e < count; e++) {
        t->low[e] = INFINITY;
        t->high[e] = -INFINITY;
    }
    for (size_t i = 0; i <= (size_t)parts; i++)
        for (size_t e = 0; e < count; e++) {
            double v = t->value[i * count + e];
            t->low[e] = v < t->low[e] ? v : t->low[e];
            t->high[e] = v > t->high[e] ? v : t->high[e];
        }
}

/* How far values between the nodes are from the cubic through the nodes, in irregular places,
 * because a wave whose length divides the distance of the nodes would be taken for a slow one;
 * and whether that is little for all functions. Ends are left out: they are projected. */
static bool predicted(struct guard_table *t, const struct guard_way *way, int parts)
{
    size_t count = (size_t)t->count;
    find_ranges(t, parts);
    for (int k = 1; k <= PROBES; k++) {
        double at = 2 + (parts - 4) * fmod(k * 0.61803398874989485, 1), whole = floor(at);
        const double *g = values(t, way, at / parts), *v = t->value + ((size_t)whole - 1) * count;
        for (size_t e = 0; e < count; e++) {
            double low = t->low[e], high = t->high[e];
            double miss = fabs(g[e] - cubic(v[e], v[count + e], v[2 * count + e], v[3 * count + e], at - whole));
            bool far = low * high > 0 && fmin(fabs(low), fabs(high)) > FAR * (high - low + miss);
            if (!far && miss > (RESOLVED + ROUNDINGS * way->grain) * (high - low) + 1e-13 * fmax(fabs(low), fabs(high)) + (way->noise ? 2 * way->noise[e] : 0))
                return false;
        }
    }
    return true;
}

void guard_table_fill(struct guard_table *t, const struct guard_way *way)
{
    size_t row = (size_t)t->count * sizeof *t->value;
    int parts = FIRST_PARTS;
    bool seen;
    reserve(t, 2 * parts + 3);
    for (int i = 1; i < parts; i++)
        put(t, i, values(t, way, (double)i / parts));
    put(t, 0, end_values(t, way, false));
    put(t, parts, end_values(t, way, true));
    do {
        for (int i = parts; i > 0; i--)
            memcpy(t->value + 2 * (size_t)i * (size_t)t->count, t->value + (size_t)i * (size_t)t->count, row);
        parts *= 2;
        reserve(t, 2 * parts + 3);
        for (int i = 1; i < parts; i += 2)
            put(t, i, values(t, way, (double)i / parts));
        seen = predicted(t, way, parts);
    } while (parts < MOST_PARTS && !seen);
    if (!seen)
        sga_limit_met(way->budget, SGA_LIMIT_TABLE_PARTS);
    memmove(t->value + 2 * (size_t)t->count, t->value + (size_t)t->count, (size_t)(parts - 1) * row);
    t->nodes = parts + 3;
    for (int i = 1; i < parts; i++)
        t->theta[i + 1] = (double)i / parts;
    t->theta[0] = 0;
    t->theta[1] = EDGE / parts;
    t->theta[parts + 1] = 1 - EDGE / parts;
    t->theta[parts + 2] = 1;
    put(t, 1, values(t, way, t->theta[1]));
    put(t, parts + 1, values(t, way, t->theta[parts + 1]));
    put(t, parts + 2, end_values(t, way, true));
}

/* One more node between two that are there. */
static void insert(struct guard_table *t, const struct guard_way *way, int at, double theta)
{
    size_t count = (size_t)t->count, behind = (size_t)(t->nodes - at);
    assert(at > 0 && t->theta[at - 1] < theta && theta < t->theta[at]);
    if (t->nodes == t->room)
        reserve(t, 2 * t->room);
    memmove(t->theta + at + 1, t->theta + at, behind * sizeof *t->theta);
    memmove(t->value + ((size_t)at + 1) * count, t->value + (size_t)at * count, behind * count * sizeof *t->value);
    t->theta[at] = theta;
    put(t, at, values(t, way, theta));
    t->nodes++;
}

void guard_table_monotone(struct guard_table *t, const struct guard_way *way)
{
    guard_table_turns(t, way);
    int at = way->from_end ? 1 : 2;
    for (int k = 0; k < t->turns; k++) {
        double theta = t->turn[k];
        while (at < t->nodes - 1 && t->theta[at] < theta)
            at++;
        if (theta - t->theta[at - 1] > SAME && t->theta[at] - theta > SAME && (way->from_end || (t->theta[at - 1] > 0 && t->theta[at] < 1)))
            insert(t, way, at, theta);
    }
    assert(guard_table_sane(t));
}

bool guard_table_sane(const struct guard_table *t)
{
    bool sane = t->nodes >= 2 && t->nodes <= t->room && t->theta[0] == 0 && t->theta[t->nodes - 1] == 1;
    for (int i = 1; i < t->nodes && sane; i++)
        sane = t->theta[i - 1] < t->theta[i];
    return sane;
}
