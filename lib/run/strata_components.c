/* Other parts of the constraint set. Constraints of which none is a product may still have a
 * union of sets as their common zeros (x y = 0 and x z = 0; x M = 0: x = 0, or det M = 0). Points
 * are taken on one part, and what was found to vanish there is not sure to vanish on another: a
 * point found from a far start where it does not is the sign of one. A search, no proof that
 * there is no other. */
#include "strata_listing.h"

#include <string.h>

#include "mem.h"

enum { STARTS = 5 };

/* Whether the function is 0 at the points of the part that was solved. */
static bool holds_here(struct points_shadow *s, expr_id e)
{
    num_ball_extend(&s->real[0].ball);
    return arb_contains_zero(num_ball_value(&s->real[0].ball, e));
}

/* A function that the reduction took for 0, and that is not at p; EXPR_UNDEF: none. */
static expr_id broken_at(struct points_shadow *s, struct points_point *p)
{
    num_ball_extend(&p->ball);
    for (int i = 0; i < s->zeros; i++) {
        arb_srcptr v = num_ball_value(&p->ball, s->zero[i].expr);
        if (arb_is_finite(v) && !arb_contains_zero(v) && holds_here(s, s->zero[i].expr))
            return s->zero[i].expr;
    }
    return EXPR_UNDEF;
}

void strata_components(struct listing *l)
{
    struct job *j = l->j;
    struct points_shadow *s = &j->shadow;
    const struct sga_solution *sol = &j->solution;
    bool found = false;
    if (j->near || !s->reals || !s->zeros || !sol->constraints || sol->sides)
        return;              /* a start says which part is meant; sides have strata of their own */
    for (uint64_t k = 1; k <= STARTS && !found && sga_budget_ok(&j->budget, NULL); k++) {
        struct points_point p;
        int rank;
        enum points_status status = strata_look_at(j, (struct strata_look){ sol->constraints, EXPR_UNDEF, STRATA_FIXED, 1, k }, &p, &rank);
        found = status == POINTS_OK && p.certified && broken_at(s, &p);
        if (found) {
            struct stratum as = { .kind = "branch", .description = strdup("another part of the constraint set: functions that vanish on the "
                                  "part that was solved do not vanish here, so that its answer is another one; give trajectory.initial near it") };
            size_t n = (size_t)j->request.system.variables;
            as.point = memcpy(sga_malloc(n * sizeof *as.point), p.x, n * sizeof *as.point);
            as.time = p.t;
            strata_add(j, EXPR_UNDEF, -1, as);
        }
        points_point_clear(&p);
    }
}
