/* Starts at the ends of roots: candidates with arguments of roots at 0. */
#include "edges.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "consistent.h"
#include "mem.h"
#include "warnings.h"

enum { MOST = SGA_MOST_EDGES };
/* As near as that the end itself is meant: searches come to it slowly, as the slopes grow without bound. */
static const double ALIKE = 1e-6;

struct edges {
    struct defined *d;
    expr_id argument[MOST]; int count;
    double *x, *best, least;
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
    if (far < e->least * (1 + ALIKE)) {
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
    double before = d->moved, *known = memcpy(e.best + n + 1, d->initial, n * sizeof *known);
    d->moved = -1;
    for (size_t j = 0; j < n; j++)             /* distances are from the guess */
        d->initial[j] = d->rq->initial[d->variable[j]];
    for (int i = 0; i < e.count; i++)
        with_zeros(&e, e.argument + i, 1);
    if (e.count > 1)
        with_zeros(&e, e.argument, e.count);
    bool taken = e.least < moved * (1 + ALIKE) && e.least != moved;
    d->moved = taken ? e.least : before;
    for (size_t j = 0; j < n; j++) {
        double at = taken ? e.best[j] : known[j];
        d->exact[j] = at == d->initial[j] ? d->exact[j] : EXPR_UNDEF;
        d->initial[j] = at;
    }
    free(e.x);
    return taken;
}
