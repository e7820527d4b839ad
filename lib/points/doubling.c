/* Steps of full precision. */
#include "doubling.h"

#include <assert.h>
#include <arb_mat.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "budget.h"
#include "mem.h"
#include "points_space.h"

enum { FROM_BITS = 120 };

/* The square part of the Jacobian at the present point, and the residuals. */
static void square_system(struct points_jacobian *j, struct num_ball *ball, const int *place, arb_mat_t J, arb_mat_t r)
{
    const struct points_space *s = j->space;
    arb_mat_zero(J);
    points_jacobian_values(j, ball);
    points_jacobian_entries(j, ball);
    for (int i = 0; i < s->constraints; i++) {
        arb_get_mid_arb(arb_mat_entry(r, i, 0), num_ball_value(ball, s->constraint[i]));
        for (int k = 0; k < j->cols[i]; k++)
            if (place[j->col[i][k]] >= 0)
                arb_get_mid_arb(arb_mat_entry(J, i, place[j->col[i][k]]), j->entry[i] + k);
    }
}

static void move(struct points_jacobian *j, struct num_ball *ball, const int *solved, const arb_mat_t d, slong prec)
{
    for (int i = 0; i < j->space->constraints; i++) {
        arb_ptr sym = ball->symbol + j->space->variable[solved[i]];
        arb_srcptr by = arb_mat_entry(d, i, 0);
        if (arb_is_finite(by))
            arf_sub(arb_midref(sym), arb_midref(sym), arb_midref(by), prec + 40, ARF_RND_NEAR);
        mag_zero(arb_radref(sym));
    }
}

void points_double_digits(struct points_jacobian *j, struct points_point *p, const int *solved, slong prec)
{
    assert(prec > 1 && p->constraints == j->space->constraints);
    int c = j->space->constraints;
    SGA_FREED int *place = sga_malloc((size_t)(j->space->variables + 1) * sizeof *place);
    SGA_ENDS(arb_mat_end) arb_mat_t J, r, d;
    arb_mat_init(J, c, c);
    arb_mat_init(r, c, 1);
    arb_mat_init(d, c, 1);
    for (int i = 0; i < j->space->variables; i++)
        place[i] = -1;
    for (int i = 0; i < c; i++)
        place[solved[i]] = i;
    bool ok = true;
    for (slong have = FROM_BITS; have < prec && ok; have *= 2) {
        p->ball.prec = 2 * have + 60;
        square_system(j, &p->ball, place, J, r);
        ok = arb_mat_approx_solve(d, J, r, p->ball.prec) && sga_budget_ok(j->space->budget, NULL);
        if (ok)
            move(j, &p->ball, solved, d, prec);
    }
}
