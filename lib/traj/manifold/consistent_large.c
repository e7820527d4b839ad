/* Consistent initial values of large systems: the same aims with sparse steps alone. */
#include "consistent.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "manifold.h"
#include "mem.h"
#include "points.h"
#include "points_random.h"
#include "seeds.h"
#include "sizes.h"
#include "watch.h"

/* Values that were not given may move this much more easily. */
static const double LOOSE = 1e3;
/* What moving them far has to gain. */
static const double ENOUGH = 0.9;

/* The values that were given stay, the others adapt, if they can do it alone. A value that
 * was not given is 0 at first, which is often a place where nothing moves (v^2 = x): then
 * a few other starts are tried. */
static bool keep_given(struct manifold *m, const struct traj_request *rq, double *x)
{
    enum { STARTS = 7 };
    int loose = 0, n = m->n;
    unsigned char *fixed = sga_calloc((size_t)n + 1, 1);
    for (int j = 0; j < n; j++) {
        fixed[j] = rq->given[j] || (rq->held && rq->held[j]);
        loose += !fixed[j];
    }
    double *y = sga_malloc((size_t)(n + 1) * sizeof *y), residual;
    uint64_t random = SGA_SEED_LARGE_START;
    bool ok = false, shifted = false;
    for (int k = 0; k < STARTS && loose > 0 && !ok && sga_watch_ok(); k++) {
        shifted = k > 0;
        for (int j = 0; j < n; j++) {
            double shift = k == 0 ? 0 : k == 1 ? 1 : k == 2 ? -1 : 4 * points_uniform(&random) - 2;
            y[j] = rq->initial[j] + (fixed[j] ? 0 : shift * m->unit[j]);
        }
        ok = manifold_project(m, rq->start, y, NULL, fixed, 40, NULL, &residual, NULL);
    }
    if (ok) {
        memcpy(x, y, (size_t)n * sizeof *y);
        if (shifted && manifold_nearest(m, rq->start, rq->initial, y, NULL, fixed, 200, NULL, NULL, NULL))
            memcpy(x, y, (size_t)n * sizeof *y);      /* back as far as it goes */
    }
    free(y);
    free(fixed);
    return ok;
}

static double distance(const struct manifold *m, const struct traj_request *rq, const double *scale, const double *x)
{
    double sum = 0;
    for (int j = 0; j < m->n; j++)
        sum += pow((x[j] - rq->initial[j]) / scale[j], 2);
    return sqrt(sum);
}

double consistent_moved(const struct manifold *m, const struct traj_request *rq, const double *scale, const double *x)
{
    double sum = 0;
    for (int j = 0; j < m->n; j++)
        if (rq->given[j])
            sum += pow((x[j] - rq->initial[j]) / scale[j], 2);
    return sqrt(sum);
}

/* The others move more easily, but not for nothing, which shifts the nearest point by some 1e-6, and by all
 * of the way where a small change of a given value does what only a large one of another does (a stiff spring,
 * a force of constraint in newton). With a guess for them where they are, and moves that cost less and less,
 * the point that is nearest for the given ones alone is approached. */
static void release_others(struct manifold *m, const struct traj_request *rq, const double *scale, double *x)
{
    enum { ROUNDS = 3, LOOSER = 4 };
    size_t n = (size_t)m->n;
    double *y = sga_malloc(4 * (n + 1) * sizeof *y), *guess = y + n + 1, *unit = guess + n + 1, *before = unit + n + 1, looser = 1;
    for (int k = 0; k < ROUNDS + LOOSER && sga_watch_ok(); k++) {
        looser *= k < ROUNDS ? 1 : LOOSE;
        if (k == ROUNDS)
            memcpy(before, x, n * sizeof *x);
        for (size_t j = 0; j < n; j++) {
            guess[j] = rq->given[j] ? rq->initial[j] : x[j];
            unit[j] = rq->given[j] ? scale[j] : scale[j] * looser;
        }
        memcpy(y, x, n * sizeof *y);
        /* the residual is seen in the units of the moves: once more in plain ones */
        bool ok = manifold_nearest(m, rq->start, guess, y, unit, rq->held, 200, NULL, NULL, NULL)
                  && (k < ROUNDS || manifold_project(m, rq->start, y, NULL, rq->held, 20, NULL, NULL, NULL))
                  && consistent_moved(m, rq, scale, y) < (k < ROUNDS ? 1 : ENOUGH) * consistent_moved(m, rq, scale, x);
        if (ok)
            memcpy(x, y, n * sizeof *y);
        else if (k < ROUNDS)
            k = ROUNDS - 1;
        if (ok && k == ROUNDS + LOOSER - 1)       /* no end of it: what is not given goes to infinity (x*y = 1 near x = 0) */
            memcpy(x, before, n * sizeof *x);
    }
    free(y);
}

/* Full steps may land on a zero far away. Walk there in short steps too, go on to the
 * nearest point from there, and keep what is nearer to the guess. *moved is left negative
 * where neither way leads to the set. */
static void shorter_way(struct manifold *m, const struct traj_request *rq, const double *scale, double *x,
                        bool found, double *moved)
{
    double *y = memcpy(sga_malloc((size_t)(m->n + 1) * sizeof *y), rq->initial, (size_t)m->n * sizeof *y);
    double here = found ? distance(m, rq, scale, x) : INFINITY;
    *moved = found ? *moved : -1;
    if (here > 0.3 && manifold_walk(m, rq->start, y, scale, rq->held, 0.2, 200)) {
        double there = distance(m, rq, scale, y);
        if (there < 0.999 * here) {
            memcpy(x, y, (size_t)m->n * sizeof *y);
            *moved = there;
        }
    }
    free(y);
}

bool consistent_large(struct manifold *m, const struct sizes *sizes, const struct traj_request *rq, const double *elsewhere, double *x)
{
    int n = m->n;
    double moved = 0, *scale = sga_malloc((size_t)(n + 1) * sizeof *scale);
    memcpy(x, rq->initial, (size_t)n * sizeof *x);
    for (int j = 0; j < n; j++)
        scale[j] = sizes_move(sizes, j, rq->initial[j]) * (rq->given[j] ? 1 : LOOSE);
    bool ok = keep_given(m, rq, x);
    if (!ok) {
        ok = manifold_nearest(m, rq->start, NULL, x, scale, rq->held, 200, &moved, NULL, NULL);
        shorter_way(m, rq, scale, x, ok, &moved);
        ok = ok || moved >= 0;
    }
    /* the guess may be a place where nothing leads on: start from a known point */
    for (int k = 0; k < 3 && !ok && elsewhere; k++) {
        double *from = sga_malloc((size_t)(n + 1) * sizeof *from), share = k == 0 ? 0.5 : k == 1 ? 0.9 : 1;
        for (int j = 0; j < n; j++)
            from[j] = rq->held && rq->held[j] ? rq->initial[j] : (1 - share) * rq->initial[j] + share * elsewhere[j];
        ok = manifold_project(m, rq->start, from, scale, rq->held, 80, NULL, NULL, NULL);
        if (ok) {
            memcpy(x, from, (size_t)n * sizeof *x);
            if (manifold_nearest(m, rq->start, rq->initial, from, scale, rq->held, 200, NULL, NULL, NULL))
                memcpy(x, from, (size_t)n * sizeof *x);
        }
        free(from);
    }
    if (ok && consistent_moved(m, rq, scale, x) > 0)
        release_others(m, rq, scale, x);
    free(scale);
    return ok;
}
