/* In balls: the start of a motion and its derivatives where it was searched for (start_equations, bounds): the nearest point of constraints, relations and bounds that it lies on, each followed
 * by its derivatives along the directions. */
#include "variation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "enclosed.h"
#include "flow.h"
#include "mem.h"
#include "start_search.h"
#include "variation_along.h"

/* Outside of a bound by less, relative to 1 + |bound|, is on it. */
static const double ON = 1e-9;

struct found {
    struct enclosed_found is;     /* first: what the caller has */
    struct flow flow;             /* its sizes are not asked for: units are the request's */
    struct sga_solution with;
    struct traj_request asked;
};

bool variation_relations(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct variation_along *a, struct sga_error *err)
{
    struct start_search search;
    size_t each = 1 + (size_t)v->directions;
    bool ok = start_search_init(&search, sys, sol, rq, err);
    v->relation = sga_calloc((size_t)rq->relations * each + 1, sizeof *v->relation);
    SGA_FREED expr_id *along = sga_calloc((size_t)v->directions + 1, sizeof *along);
    for (int i = 0; i < rq->relations && ok; i++) {
        along_of(a, search.relation[i], along);
        for (size_t d = 0; d < each; d++) {
            v->relation[(size_t)i * each + d] = rq->relation[i];
            v->relation[(size_t)i * each + d].value = d ? along[d - 1] : search.relation[i];
        }
    }
    v->request.relation = v->relation;
    v->request.relations = ok ? rq->relations * (int)each : 0;
    start_search_clear(&search);
    return ok;
}

static void add(struct found *f, expr_id e)
{
    struct sga_constraint *to = (struct sga_constraint *)f->with.constraint + f->with.constraints++;
    *to = (struct sga_constraint){ .expr = e, .generation = 1, .restriction = -1, .source = -1 };
}

struct enclosed_found *variation_found(const struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, const double *low, const double *high)
{
    struct found *f = sga_calloc(1, sizeof *f);
    int each = 1 + v->directions;
    f->with = *sol;
    f->with.constraint = sga_calloc((size_t)(sol->constraints + rq->relations + v->n * each) + 1, sizeof *f->with.constraint);
    if (sol->constraints)
        memcpy((struct sga_constraint *)f->with.constraint, sol->constraint, (size_t)sol->constraints * sizeof *sol->constraint);
    for (int i = 0; i < rq->relations; i += each)
        for (int d = 0; d < each && !expr_is_zero(sys->store, rq->relation[i].value); d++)
            add(f, rq->relation[i + d].value);
    for (int j = 0; j < v->n && low; j++)
        for (int side = 0; side < 2; side++) {
            double bound = (side ? high : low)[j];
            if (!isfinite(bound) || fabs(rq->initial[j] - bound) > ON * (1 + fabs(bound)))
                continue;
            add(f, expr_sub(sys->store, sys->store->symbol[sys->variable[j].symbol].node, expr_double(sys->store, bound)));
            for (int d = 1; d < each; d++)
                add(f, sys->store->symbol[sys->variable[d * v->n + j].symbol].node);
        }
    f->flow.n = sys->variables;
    f->asked = *rq;
    f->asked.relations = 0;
    f->asked.found = NULL;
    f->is = (struct enclosed_found){ .flow = &f->flow, .sys = sys, .with = &f->with, .asked = &f->asked, .near = rq->initial };
    return &f->is;
}

void variation_found_free(struct enclosed_found *found)
{
    struct found *f = (struct found *)found;
    if (f)
        free((struct sga_constraint *)f->with.constraint);
    free(f);
}
