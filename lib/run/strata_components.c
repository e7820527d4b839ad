/* Other parts of the constraint set. Constraints of which none is a product may still have a
 * union of sets as their common zeros (x y = 0 and x z = 0; x M = 0: x = 0, or det M = 0). Points
 * are taken on one part, and what was found to vanish there is not sure to vanish on another: a
 * point found from a far start where it does not is the sign of one, where all that was given holds
 * there. A search, no proof that there is no other. */
#include "strata_listing.h"

#include <string.h>

#include "mem.h"
#include "sides.h"

enum { STARTS = 5 };

/* Whether the function is 0 at the points of the part that was solved. */
static bool holds_here(struct points_shadow *s, expr_id e)
{
    num_ball_extend(&s->real[0].ball);
    return arb_contains_zero(num_ball_value(&s->real[0].ball, e));
}

/* A function among the first so many that the reduction took for 0, and that is not at p. */
static bool broken_at(struct points_shadow *s, struct points_point *p, int zeros)
{
    num_ball_extend(&p->ball);
    for (int i = 0; i < zeros; i++) {
        arb_srcptr v = num_ball_value(&p->ball, s->zero[i].expr);
        if (arb_is_finite(v) && !arb_contains_zero(v) && holds_here(s, s->zero[i].expr))
            return true;
    }
    return false;
}

/* A given equation without derivatives, or a restriction, that is not satisfied at p; EXPR_UNDEF: all are. */
static expr_id violated(const struct job *j, struct points_point *p)
{
    const struct sys_system *sys = &j->request.system;
    num_ball_extend(&p->ball);
    for (int i = 0; i < sys->rows + sys->restrictions; i++) {
        expr_id e = i < sys->rows ? sys->row[i].alpha : sys->restriction[i - sys->rows];
        if (i < sys->rows && sys->row[i].entries)
            continue;
        arb_srcptr v = num_ball_value(&p->ball, e);
        if (!arb_is_finite(v) || !arb_contains_zero(v))
            return e;
    }
    return EXPR_UNDEF;
}

/* From p, on the constraints, to a point where the equation that they leave open holds too. */
static bool meet(struct job *j, struct points_point *p)
{
    expr_id e = violated(j, p);
    if (!e)
        return true;
    struct points_point q;
    int rank;
    struct strata_look look = { .c = j->solution.constraints, .factor = e, .starts = 1, .far = true, .from = p, .point_only = true };
    bool met = strata_look_at(j, look, &q, &rank) == POINTS_OK && q.certified && !violated(j, &q);
    points_point_clear(p);
    *p = q;
    return met;
}

/* From the k-th random start: a point of another part. */
static bool found(struct job *j, uint64_t k, int zeros, struct points_point *p)
{
    const struct sga_solution *sol = &j->solution;
    struct strata_look look = { .c = sol->constraints, .starts = 1, .seed = k, .far = true, .point_only = true };
    int rank;
    return strata_look_at(j, look, p, &rank) == POINTS_OK && p->certified && broken_at(&j->shadow, p, zeros) && meet(j, p)
           && broken_at(&j->shadow, p, zeros) && points_on_sides(j->request.system.store, &p->ball, sol->side, sol->sides);
}

static void list_part(struct job *j, const double *x, double t)
{
    struct stratum as = { .kind = "branch", .description = strdup("another part of the constraint set: functions that vanish on the "
                          "part that was solved do not vanish here, so that its answer is another one; give trajectory.initial near it") };
    size_t n = (size_t)j->request.system.variables;
    as.point = memcpy(sga_malloc(n * sizeof *as.point), x, n * sizeof *as.point);
    as.time = t;
    strata_add(j, EXPR_UNDEF, -1, as);
}

/* Those that the reduction knows of (sga.h); where it was told where to look, a search. */
void strata_components(struct listing *l)
{
    struct job *j = l->j;
    for (int i = 0; i < j->solution.elsewheres && !j->on_part; i++)
        list_part(j, j->solution.elsewhere[i].x, j->solution.elsewhere[i].t);
    if (j->solution.elsewheres)
        return;
    struct points_shadow *s = &j->shadow;
    int zeros = s->zeros;
    bool done = !s->reals || !zeros || !j->solution.constraints || j->on_part;
    for (uint64_t k = 1; k <= STARTS && !done && sga_budget_ok(&j->budget, NULL); k++) {
        struct points_point p;
        done = found(j, k, zeros, &p);
        if (done)
            list_part(j, p.x, p.t);
        points_point_clear(&p);
    }
}
