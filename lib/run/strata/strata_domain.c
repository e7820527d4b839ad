/* Where the equations as given have no value: zeros of their denominators, and of what they take the
 * logarithm of, that the constraint set reaches. Only the boundary is listed, not what happens there. */
#include "strata_listing.h"

#include <stdlib.h>

#include "arena.h"
#include "domain.h"
#include "facts.h"
#include "points.h"
#include "reduction.h"
#include "run_job.h"
#include "mem.h"
#include "poly.h"
#include "request.h"
#include "stratum.h"

/* The functions that were considered, or that are to be. */
struct looked { expr_id *factor; int count; size_t cap; };

static void keep(struct looked *l, expr_id factor)
{
    SGA_RESERVE(l->factor, l->cap, l->count + 1);
    l->factor[l->count++] = factor;
}

static bool again(const struct looked *looked, expr_id factor)
{
    for (int i = 0; i < looked->count; i++)
        if (looked->factor[i] == factor)
            return true;
    return false;
}

static void consider(struct listing *l, expr_id factor, struct looked *looked)
{
    struct job *j = l->j;
    struct points_point p;
    int rank;
    unsigned f = expr_facts_of(l->facts, &j->request->store, factor);
    if (f & EXPR_NONZERO || !(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)) || again(looked, factor) || !job_goes_on(j))
        return;
    keep(looked, factor);
    enum strata_moving moving = f & EXPR_HAS_VARIABLE ? STRATA_FIXED : STRATA_TIME;
    enum points_status status = strata_look_at(j, (struct strata_look){ .c = j->solution->constraints, .factor = factor, .moving = moving, .point_only = true }, &p, &rank);
    points_point_clear(&p);
    if (status == POINTS_OK)
        strata_add(j, factor, -1, (struct stratum){ .kind = "domain" });
}

static void factors(struct listing *l, expr_id value, struct looked *looked)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, l->j->budget);
    struct poly_factors f;
    if (!poly_numerator_factors(&l->j->request->store, value, &limits, &f)) {
        consider(l, value, looked);
        return;
    }
    for (int i = 0; i < f.factors; i++)
        if (!f.factor[i].never_zero)
            consider(l, f.factor[i].expr, looked);
    poly_factors_clear(&f);
}

/* Marks what the constraints divide by or take the logarithm of: where it vanishes they have no value, so no point of
 * their set lies there and none is looked for. The caller frees it. */
static unsigned char *beyond_set(const struct job *j)
{
    const struct expr_store *st = &j->request->store;
    unsigned char *mark = sga_calloc((size_t)st->nodes, 1);
    int c = j->solution->constraints;
    SGA_ARENA(mem);
    expr_id *con = sga_take(&mem, (size_t)(c + 1) * sizeof *con);
    struct expr_cone cone;
    for (int i = 0; i < c; i++)
        con[i] = j->solution->constraint[i].expr;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, con, c);
    for (int i = 0; i < cone.count; i++)
        mark[domain_divisor(st, cone.list[i])] = 1;
    expr_cone_clear(&cone);
    return mark;
}

void strata_domain(struct listing *l)
{
    const struct sys_system *sys = &l->j->request->system;
    struct looked looked = { .count = 0 }, value = { .count = 0 };
    expr_id *root;
    int at = sys_expressions(sys, &root);
    unsigned char *beyond = beyond_set(l->j);
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(sys->store, &cone, root, at);
    for (int i = 0; i < cone.count; i++) {
        expr_id d = domain_divisor(sys->store, cone.list[i]);
        if (d && !beyond[d] && !expr_is_const(sys->store, d))
            keep(&value, d);
    }
    expr_cone_clear(&cone);
    free(beyond);
    free(root);
    for (int i = 0; i < value.count; i++)
        factors(l, value.factor[i], &looked);
    free(value.factor);
    free(looked.factor);
}
