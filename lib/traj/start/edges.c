/* Starts at the ends of roots: candidates with arguments of roots at 0. */
#include "edges.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "consistent.h"
#include "error.h"
#include "kinds.h"
#include "manifold.h"
#include "mem.h"
#include "sizes.h"
#include "warnings.h"

enum { MOST = SGA_MOST_EDGES };
/* Distances that roundings do not tell apart. Where an end is the nearest point all others are farther. */
static const double ALIKE = 1e-12;

struct edges {
    struct defined *d;
    expr_id argument[MOST]; int count;
    double *x, *best, least;
    bool any;              /* best is one of these: until then `least` is what is to be beaten */
};

/* Arguments of roots in what is defined, with the definitions put in. */
static void find(struct edges *e)
{
    const struct defined *d = e->d;
    struct expr_store *st = d->sys->store;
    struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < d->sol->definitions; i++) {
        expr_cone_of(st, &cone, &d->sol->definition[i].value, 1);
        for (int k = 0; k < cone.count; k++) {
            enum expr_op op = expr_op_of(st, cone.list[k]);
            expr_id a = st->node[cone.list[k]].a;
            if ((op != EXPR_SQRT && op != EXPR_POW) || expr_is_const(st, a))
                continue;
            expr_substitute(st, &a, 1, d->map);
            bool known = expr_is_const(st, a);
            for (int q = 0; q < e->count && !known; q++)
                known = e->argument[q] == a;
            if (!known && e->count == MOST)
                sga_limit_met(d->rq->budget, SGA_LIMIT_EDGES);
            if (!known && e->count < MOST)
                e->argument[e->count++] = a;
        }
    }
    expr_cone_clear(&cone);
}

/* Over what distance given values of the whole moved; infinite where something has no value. */
static double moved_to(const struct defined *d, const double *x, double moved)
{
    double *whole = defined_lift(d, memcpy(sga_malloc(((size_t)d->system.variables + 1) * sizeof *whole), x, (size_t)d->system.variables * sizeof *x));
    double far = 0;
    for (int j = 0; j < d->sys->variables; j++)
        far = isfinite(whole[j]) ? far : INFINITY;
    far = isfinite(far) ? defined_moved(d, whole, moved) : far;
    free(whole);
    return far;
}

/* Whether x takes the place of the best: it is nearer, or as near with the larger value of the first variable, by name, that differs. */
static bool is_better(const struct edges *e, const double *x, double far)
{
    if (!e->any || fabs(far - e->least) > ALIKE * e->least)
        return far < e->least * (1 + ALIKE);
    int n = e->d->system.variables, *by_name = sga_malloc(((size_t)n + 1) * sizeof *by_name), i = 0;
    sys_by_name(&e->d->system, by_name);
    while (i < n && x[by_name[i]] == e->best[by_name[i]])
        i++;
    bool better = i < n && x[by_name[i]] > e->best[by_name[i]];
    free(by_name);
    return better;
}

/* The start with these arguments at 0, where it is the best so far. */
static void with_zeros(struct edges *e, const expr_id *argument, int count)
{
    struct defined *d = e->d;
    struct sga_solution more = d->solution;
    struct sga_error ignored = { 0 };
    struct manifold m;
    struct sizes sizes;
    size_t c = (size_t)more.constraints, n = (size_t)d->system.variables;
    if (more.constraints + count > d->system.variables)
        return;
    more.constraint = sga_calloc(c + (size_t)count + 1, sizeof *more.constraint);
    if (c)
        memcpy(more.constraint, d->solution.constraint, c * sizeof *more.constraint);
    for (int i = 0; i < count; i++)
        more.constraint[more.constraints++].expr = argument[i];
    sizes_init(&sizes, &d->system, &d->request);
    double moved, far;
    bool ok = manifold_init(&m, &d->system, &more, NULL, &ignored);
    m.unit = sizes.weight;
    ok = ok && consistent_start(&m, &d->system, &more, &sizes, &d->request, NULL, e->x, &moved, &ignored);
    far = ok ? moved_to(d, e->x, moved) : INFINITY;
    if (isfinite(far) && is_better(e, e->x, far)) {
        e->any = true;
        e->least = far;
        memcpy(e->best, e->x, n * sizeof *e->best);
    }
    manifold_clear(&m);
    sizes_clear(&sizes);
    free(more.constraint);
}

bool edges_start(struct defined *d, double moved)
{
    struct edges e = { .d = d, .least = moved };
    size_t n = (size_t)d->system.variables;
    find(&e);
    e.x = sga_calloc(3 * n + 3, sizeof *e.x);
    e.best = e.x + n + 1;
    assert(!(moved < 0));
    double before = d->moved, *known = memcpy(e.best + n + 1, d->initial, n * sizeof *known);
    d->moved = -1;
    for (size_t j = 0; j < n; j++)             /* distances are from the guess */
        d->initial[j] = d->rq->initial[d->variable[j]];
    for (int i = 0; i < e.count; i++)
        with_zeros(&e, e.argument + i, 1);
    if (e.count > 1)
        with_zeros(&e, e.argument, e.count);
    d->moved = e.any ? e.least : before;
    for (size_t j = 0; j < n; j++) {
        double at = e.any ? e.best[j] : known[j];
        d->exact[j] = at == d->initial[j] ? d->exact[j] : EXPR_UNDEF;
        d->initial[j] = at;
    }
    free(e.x);
    return e.any;
}
