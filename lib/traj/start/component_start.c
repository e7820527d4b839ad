/* From the component to the guess, not from the guess to whatever is nearest. */
#include "component_start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "consistent.h"
#include "field.h"
#include "flow.h"
#include "manifold.h"
#include "mem.h"
#include "reduction.h"
#include "seeds.h"
#include "set_points.h"
#include "sizes.h"
#include "system.h"
#include "tiers.h"
#include "watch.h"

enum { MOST = 40 };      /* variables: descent to all digits is dense */
static const double ON = 1e-10, SHORTEST = 1.0 / 64;
/* In units: half of the digits. */
static const double HALF = 1e-6;

static bool drops(struct flow *f, const struct traj_request *rq, const double *x)
{
    field_load(f->field, rq->start, x);
    int told = field_rank_told(f->field);
    return told >= 0 && told < f->field->generic_rank;
}

/* The constraints solved variable by variable, the others as they were guessed. */
static bool by_shape(const struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double *y)
{
    struct set_points on;
    struct points_point p;
    set_points_init(&on, sys, sol, sol->constraints, 0, 0);
    on.space.parameters = 0;
    on.space.near = rq->initial;
    on.space.near_time = rq->start;
    on.space.starts = 1;
    on.space.by_shape = true;
    on.space.budget = rq->budget;
    uint64_t random = SGA_SEED_COMPONENT_START;
    bool ok = points_find(&on.space, 0, &random, 64, &p) == POINTS_OK && p.triangular;
    if (ok)
        memcpy(y, p.x, (size_t)f->n * sizeof *y);
    points_point_clear(&p);
    set_points_clear(&on);
    return ok;
}

/* The same beside x, where what half of the digits tell from 0 is 0: a double zero is found to no more. */
static bool drops_beside(struct flow *f, const struct traj_request *rq, const double *x)
{
    SGA_FREED double *y = memcpy(sga_malloc(((size_t)f->n + 1) * sizeof *y), x, (size_t)f->n * sizeof *y);
    bool any = false;
    for (int j = 0; j < f->n; j++)
        if (x[j] != 0 && x[j] != rq->initial[j] && fabs(x[j]) < HALF * sizes_move(f->sizes, j, 0)) {
            y[j] = 0;
            any = true;
        }
    return any && fabs(manifold_residual(f->manifold, rq->start, y, NULL, NULL)) < ON && drops(f, rq, y);
}

/* z, on the component, descends to what is nearest to the guess. False: it left the component, or came to where the rank drops (*ends). */
static bool descends(struct flow *f, const struct sys_system *sys, const struct traj_request *rq, double *z, bool *ends)
{
    double far[TIERS];
    bool on = tiers_descend(f->manifold, sys, f->sizes, rq, z, far) && fabs(manifold_residual(f->manifold, rq->start, z, NULL, NULL)) < ON;
    *ends = on && (drops(f, rq, z) || drops_beside(f, rq, z));
    return on && !*ends;
}

/* The same while the guess itself comes from y to where it is, so that each descent is short and none goes over to another component. */
static bool follows(struct flow *f, const struct sys_system *sys, const struct traj_request *rq, const double *y, double *z)
{
    size_t n = (size_t)f->n;
    double at = 0, step = 0.25, *target = sga_malloc(2 * (n + 1) * sizeof *target), *next = target + n + 1;
    struct traj_request own = *rq;
    bool ends;
    own.initial = target;
    memcpy(z, y, n * sizeof *z);
    while (at < 1 && step > SHORTEST && sga_watch_ok()) {
        double to = fmin(1, at + step);
        for (size_t j = 0; j < n; j++)
            target[j] = to < 1 ? y[j] + to * (rq->initial[j] - y[j]) : rq->initial[j];
        memcpy(next, z, n * sizeof *next);
        if (descends(f, sys, &own, next, &ends)) {
            memcpy(z, next, n * sizeof *z);
            at = to;
            step *= 2;
        } else {
            step /= 2;
        }
    }
    free(target);
    return at == 1;
}

/* As far as half of the digits tell. */
static bool same_place(const struct flow *f, const double *x, const double *y)
{
    bool same = true;
    for (int j = 0; j < f->n && same; j++)
        same = fabs(y[j] - x[j]) <= HALF * sizes_move(f->sizes, j, x[j]);
    return same;
}

/* From y, on or near the component, with the held values put in: the nearest point; or, if y is as good as any, y itself where the descent leaves
 * the component. Where the rank drops at the nearest point, or that is x, where it does, nothing of the component is nearest. */
static bool nearest_from(struct flow *f, const struct sys_system *sys, const struct traj_request *rq, bool good, const double *x, double *y)
{
    size_t n = (size_t)f->n;
    double residual, *z = sga_malloc((n + 1) * sizeof *z);
    for (size_t j = 0; j < n; j++)
        y[j] = rq->held && rq->held[j] ? rq->initial[j] : y[j];
    bool ok = manifold_project(f->manifold, rq->start, y, NULL, rq->held, 60, NULL, &residual, NULL) && !drops(f, rq, y);
    memcpy(z, y, n * sizeof *z);
    bool ends = false, found = ok && descends(f, sys, rq, z, &ends), there = ends || (ok && same_place(f, x, z));
    found = found || (ok && !there && follows(f, sys, rq, y, z));
    if (found)
        memcpy(y, z, n * sizeof *z);
    free(z);
    return !there && (found || (ok && good)) && !same_place(f, x, y);
}

void component_start(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                     double *x, double *moved)
{
    size_t n = (size_t)f->n;
    if (!rq->on || !(*moved > ON) || f->n > MOST || f->manifold->c == 0 || rq->rates || !drops(f, rq, x))
        return;
    double *y = sga_malloc(2 * (n + 1) * sizeof *y), *scale = y + n + 1;
    bool ok = !sys->parameters && by_shape(f, sys, sol, rq, y) && nearest_from(f, sys, rq, true, x, y);
    if (!ok) {
        memcpy(y, rq->on, n * sizeof *y);
        ok = nearest_from(f, sys, rq, false, x, y);
    }
    if (ok) {
        for (size_t j = 0; j < n; j++)
            scale[j] = sizes_move(f->sizes, (int)j, rq->initial[j]);
        memcpy(x, y, n * sizeof *x);
        *moved = consistent_moved(f->manifold, rq, scale, x);
    }
    free(y);
}
