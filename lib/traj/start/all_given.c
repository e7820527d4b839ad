/* The start on all equations: projections from several places, with rows that depend on each other at the end of them. */
#include "all_given.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "leastnorm.h"
#include "manifold.h"
#include "mem.h"
#include "normal.h"
#include "points_random.h"
#include "reduction.h"
#include "redundant.h"
#include "seeds.h"
#include "sizes.h"
#include "tiers.h"
#include "watch.h"

/* Past it the dense factors of dependent rows take too long. The guess may lie where the further part meets the set, and nothing
 * leads on: starts go around it, and the nearest point counts. */
enum { MOST = 200, STARTS = 16, SMALL = 40 };     /* SMALL: variables, for the nearest point of each start to all digits */
/* Values that were not given may move this much more easily. */
static const double LOOSE = 1e3;
/* Of residuals; and of distances that are the same. */
static const double ON_ALL = 1e-10, ALIKE = 1e-9;

/* From a point of the component that is meant, where the held values are put in. */
static bool from_component(struct manifold *m, const struct traj_request *rq, const double *scale, double *y)
{
    double residual;
    for (int j = 0; j < m->n; j++)
        y[j] = rq->held && rq->held[j] ? rq->initial[j] : rq->on[j];
    return manifold_project(m, rq->start, y, scale, rq->held, 60, NULL, &residual, NULL);
}

/* From the k-th start to a point where all equations hold; false: it leads nowhere. The last is a point of the component that is meant. */
static bool reach(struct manifold *m, const struct traj_request *rq, const double *scale, int k, uint64_t *random, double *y)
{
    if (k == STARTS)
        return rq->on && from_component(m, rq, scale, y);
    for (int j = 0; j < m->n; j++) {
        double shift = 0.2 * (1 + k / 3) * (2 * points_uniform(random) - 1);
        y[j] = rq->initial[j] + (k && !(rq->held && rq->held[j]) ? shift * fmax(fabs(rq->initial[j]), m->unit[j]) : 0);
    }
    double residual;
    return manifold_project(m, rq->start, y, scale, rq->held, 60, NULL, &residual, NULL);
}

/* What a search works on: the constraints and the given equations together. */
struct search {
    struct flow *f;
    const struct sys_system *sys;
    const struct traj_request *rq;
    const struct sga_solution *all;
    struct manifold m;            /* of all */
    int rank;                     /* how many of them are independent */
};

/* From y along the set of `on` to the nearest point; all equations hold at its end, or y stays. */
static bool descend_on(struct search *s, struct manifold *on, double *y, double far[TIERS])
{
    size_t n = (size_t)s->m.n;
    double *z = memcpy(sga_malloc((n + 1) * sizeof *z), y, n * sizeof *y);
    bool ok = tiers_descend(on, s->sys, s->f->sizes, s->rq, z, far) && fabs(manifold_residual(&s->m, s->rq->start, z, NULL, NULL)) < ON_ALL;
    if (ok)
        memcpy(y, z, n * sizeof *y);
    free(z);
    return ok;
}

/* The same on the equations whose gradients at y are the most independent: those that are independent elsewhere may depend on each other at the
 * nearest point. */
static bool descend_here(struct search *s, double *y, double far[TIERS])
{
    int n = s->m.n, c = s->m.c;
    double *J = sga_calloc((size_t)n * (size_t)c + (size_t)c * (size_t)(c + 1) + 1, sizeof *J);
    int *row = sga_calloc((size_t)c + 1, sizeof *row);
    struct sga_solution few = *s->all;
    few.constraint = sga_calloc((size_t)c + 1, sizeof *few.constraint);
    few.constraints = s->rank;
    bool ok = manifold_residual(&s->m, s->rq->start, y, NULL, NULL) >= 0;
    for (int i = 0; i < c && ok; i++)
        for (int k = 0; k < s->m.cols[i]; k++)
            J[i * n + s->m.col[i][k]] = s->m.step->value[i][k];
    ok = ok && points_least_norm_factor(c, n, J, row, J + n * c) == s->rank;
    for (int i = 0; i < s->rank && ok; i++)
        few.constraint[i] = s->all->constraint[row[i]];
    struct manifold here;
    struct sga_error none = { 0 };
    if (ok && (ok = manifold_init(&here, s->sys, &few, NULL, &none))) {
        here.unit = s->m.unit;
        ok = descend_on(s, &here, y, far);
        manifold_clear(&here);
    }
    free(few.constraint);
    free(row);
    free(J);
    return ok;
}

/* From y, where all equations hold, to the nearest such point: on independent ones where these lead along, as dependent rows
 * stop the search early. */
static bool nearest_from(struct search *s, const double *scale, double *y, double far[TIERS])
{
    if (s->m.n <= SMALL && (descend_on(s, s->f->manifold, y, far) || descend_here(s, y, far)))
        return true;
    return manifold_nearest(&s->m, s->rq->start, s->rq->initial, y, scale, s->rq->held, 200, NULL, NULL, NULL);
}

static double given_distance(const struct manifold *m, const struct traj_request *rq, const double *scale, const double *y)
{
    double sum = 0;
    for (int j = 0; j < m->n; j++)
        if (rq->given[j])
            sum += pow((y[j] - rq->initial[j]) / scale[j], 2);
    return sqrt(sum);
}

/* The best of all starts into x. */
static bool best(struct search *s, double *x, double *moved)
{
    struct manifold *m = &s->m;
    const struct traj_request *rq = s->rq;
    size_t n = (size_t)m->n;
    double *y = sga_malloc(2 * (n + 1) * sizeof *y), *scale = y + n + 1, least = INFINITY, far[TIERS];
    uint64_t random = SGA_SEED_ALL_GIVEN;
    for (size_t j = 0; j < n; j++)
        scale[j] = sizes_move(s->f->sizes, (int)j, rq->initial[j]) * (rq->given[j] ? 1 : LOOSE);
    for (int k = STARTS; k >= 0 && sga_watch_ok(); k--) {
        double given;
        if (!reach(m, rq, scale, k, &random, y) || !nearest_from(s, scale, y, far)
            || (given = given_distance(m, rq, scale, y)) >= least - ALIKE)
            continue;
        least = given;
        memcpy(x, y, n * sizeof *x);
    }
    free(y);
    *moved = isfinite(least) ? least : *moved;
    return isfinite(least);
}

bool all_given_start(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                     double *x, double *moved)
{
    struct sga_error none = { 0 };
    struct sga_solution all = *sol;
    size_t c = (size_t)sol->constraints, more = (size_t)f->given->count;
    if (c + more > MOST)
        return false;
    all.constraint = sga_calloc(c + more + 1, sizeof *all.constraint);
    memcpy(all.constraint, sol->constraint, c * sizeof *all.constraint);
    for (size_t k = 0; k < more; k++)
        all.constraint[c + k] = (struct sga_constraint){ .expr = f->given->equation[k], .replaced = EXPR_UNDEF };
    all.constraints = (int)(c + more);
    struct search s = { .f = f, .sys = sys, .rq = rq, .all = &all, .rank = sol->constraints };
    bool ok = manifold_init(&s.m, sys, &all, NULL, &none);
    if (ok) {
        s.m.unit = f->manifold->unit;
        ok = best(&s, x, moved);
        manifold_clear(&s.m);
    }
    free(all.constraint);
    return ok;
}
