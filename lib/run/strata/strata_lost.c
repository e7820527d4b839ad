/* Parts of a generation's set that a division left out. A left kernel vector of A made with the pivot p is one of full
 * length times a power of p: (x/z, y/z, 1) stands for (x, y, z), and x y = 0 for x y z = 0. Where p vanishes while the
 * rank stays, another pivot would have done, and its constraints say which points belong to the set. So the
 * zeros of each pivot are looked at as points: where the rank is what it is in general, some velocity solves the
 * equations and is tangent to the earlier constraints, and the constraints of the generation do not hold, another part
 * of the set was left out. */
#include "strata_listing.h"

#include <assert.h>
#include <stdlib.h>

#include "facts.h"
#include "run_job.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "request.h"
#include "sides.h"
#include "stratum.h"

enum { MOST = SGA_MOST_LOST_PARTS };

/* The functions that were looked at, each on the set of the first `before` constraints. */
struct seen { expr_id factor[MOST]; int before[MOST], count; };

/* How many constraints came before generation g, and with it. */
static int up_to(const struct sga_solution *sol, int g)
{
    int k = 0;
    while (k < sol->constraints && sol->constraint[k].generation <= g)
        k++;
    return k;
}

static bool again(struct seen *s, expr_id factor, int before)
{
    for (int i = 0; i < s->count; i++)
        if (s->factor[i] == factor && s->before[i] == before)
            return true;
    assert(s->count < MOST);
    s->factor[s->count] = factor;
    s->before[s->count++] = before;
    return false;
}

/* Whether one of the constraints from..to-1 is not zero at p. */
static bool off_set(struct job *j, struct points_point *p, int from, int to)
{
    num_ball_extend(&p->ball);
    for (int i = from; i < to; i++) {
        arb_srcptr v = num_ball_value(&p->ball, j->solution->constraint[i].expr);
        if (arb_is_finite(v) && !arb_contains_zero(v))
            return true;
    }
    return false;
}

/* The factor, and given equations without derivatives among the constraints before..with-1: no pivot was needed for them. Malloced. */
static expr_id *together(const struct job *j, expr_id factor, int before, int with, int *count)
{
    const struct sys_system *sys = &j->request->system;
    expr_id *e = sga_malloc((size_t)(with - before + 1) * sizeof *e);
    e[0] = factor;
    *count = 1;
    for (int i = before; i < with; i++) {
        const struct sga_constraint *k = j->solution->constraint + i;
        if (k->origin == SGA_FROM_ROWS && k->source >= 0 && k->source < sys->rows && !sys->row[k->source].entries)
            e[(*count)++] = k->expr;
    }
    return e;
}

static void consider(struct listing *l, expr_id factor, int before, int with, struct seen *seen)
{
    struct job *j = l->j;
    struct points_point p;
    int rank;
    bool solvable = false;
    unsigned f = expr_facts_of(l->facts, &j->request->store, factor);
    if (f & EXPR_NONZERO || !(f & EXPR_HAS_VARIABLE) || !job_goes_on(j))
        return;
    if (seen->count == MOST) {
        j->strata.skipped = true;
        sga_limit_met(j->budget, SGA_LIMIT_LOST_PARTS);
        return;
    }
    if (again(seen, factor, before))
        return;
    int count;
    expr_id *e = together(j, factor, before, with, &count);
    struct strata_look look = { .c = before, .factor = factor, .squared = e, .squares = count, .far = true, .solvable = &solvable };
    enum points_status status = strata_look_at(j, look, &p, &rank);
    free(e);
    bool lost = status == POINTS_OK && p.certified && solvable && points_on_sides(j->request->system.store, &p.ball, j->solution->side, j->solution->sides)
                && off_set(j, &p, before, with) && rank == strata_general_rank(l, before);
    points_point_clear(&p);
    if (lost)
        strata_add(j, factor, before, (struct stratum){ .kind = "branch" });
}

static void factors(struct listing *l, expr_id value, int g, struct seen *seen)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, l->j->budget);
    struct poly_factors f;
    int before = up_to(l->j->solution, g - 1), with = up_to(l->j->solution, g);
    if (before == with || !poly_numerator_factors(&l->j->request->store, value, &limits, &f))
        return;
    for (int i = 0; i < f.factors; i++)
        if (!f.factor[i].never_zero)
            consider(l, f.factor[i].expr, before, with, seen);
    poly_factors_clear(&f);
}

void strata_lost(struct listing *l)
{
    const struct sga_solution *sol = l->j->solution;
    struct seen seen = { .count = 0 };
    for (int i = 0; i < sol->pivots + sol->deads; i++) {
        const struct sga_pivot *p = i < sol->pivots ? sol->pivot + i : sol->dead + (i - sol->pivots);
        if (expr_is_const(&l->j->request->store, p->value))
            continue;
        if (l->j->request->system.variables > SGA_MOST_LOST_PARTS_VARIABLES) {
            l->j->strata.skipped = true;
            sga_limit_met(l->j->budget, SGA_LIMIT_LOST_PARTS_VARIABLES);
        } else
            factors(l, p->value, p->generation, &seen);
    }
}
