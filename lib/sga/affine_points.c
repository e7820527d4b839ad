/* Points of affine sets, for those who ask for values. */
#include "affine.h"

#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "budget.h"
#include "error.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "points_random.h"

bool affine_sample(struct state *s, int constraints)
{
    int all = s->sol->constraints;
    s->sol->constraints = constraints;
    enum points_status status = state_sample_defined(s);
    s->sol->constraints = all;
    if (status == POINTS_OK)
        return true;
    if (status == POINTS_STOPPED)
        return sga_budget_ok(s->options->budget, s->err);
    return sga_fail(s->err, SGA_E_NO_REAL_POINT, "no point of the final set was found where the equations have values; "
                    "give trajectory.initial near such a point");
}

/* Free coordinates, parameters and time: any short numbers, near the guess where there is one. */
static void choose_free(struct affine_run *r, struct points_point *p)
{
    const struct points_space *space = &r->s->space;
    uint64_t *random = &r->s->oracle->random;
    for (int j = 0; j < r->a->n; j++) {
        double u = points_uniform(random) - 0.5, x = space->near ? space->near[j] : 0;
        p->x[j] = points_short(x + u * (space->near ? 0.1 * (1 + (x < 0 ? -x : x)) : 3));
        num_ball_set_d(&p->ball, space->variable[j], p->x[j]);
    }
    for (int i = 0; i < space->parameters; i++) {
        p->parameter[i] = points_short(0.5 + 1.5 * points_uniform(random));
        num_ball_set_d(&p->ball, space->parameter[i], p->parameter[i]);
    }
    p->t = points_short(space->near_time + (space->time_unit > 0 ? space->time_unit : 1) * 0.9 * points_uniform(random));
    if (space->time >= 0)
        num_ball_set_d(&p->ball, space->time, p->t);
}

/* The pivot variables of the basis, each by one division: balls, so the point is proved. False: some atom has no value. */
static bool solve_pivots(struct affine_run *r, struct points_point *p)
{
    const struct points_space *space = &r->s->space;
    SGA_ENDS(arb_end) arb_t sum = { 0 }, c = { 0 };
    bool ok = true;
    num_ball_extend(&p->ball);
    for (int i = 0; i < r->basis.rows && ok; i++) {
        const struct exact_row *f = r->basis.row + i;
        int at = exact_row_before(f, r->basis.pivot[i]);
        arb_zero(sum);
        for (int k = 0; k < f->entries; k++) {
            if (k == at)
                continue;
            arb_set_fmpz(c, f->value + k);
            arb_addmul(sum, c, f->col[k] < r->a->n ? p->ball.symbol + space->variable[f->col[k]]
                       : num_ball_value(&p->ball, r->a->atom[f->col[k] - r->a->n].expr), p->ball.prec + 64);
        }
        arb_neg(sum, sum);
        arb_div_fmpz(sum, sum, f->value + at, p->ball.prec + 64);
        ok = arb_is_finite(sum);
        num_ball_set(&p->ball, space->variable[r->basis.pivot[i]], sum);
        p->x[r->basis.pivot[i]] = arf_get_d(arb_midref(sum), ARF_RND_NEAR);
        p->solved[i] = r->basis.pivot[i];
    }
    num_ball_forget(&p->ball);
    return ok;
}

static bool exact_point(struct affine_run *r, struct points_point *p)
{
    const struct points_space *space = &r->s->space;
    *p = (struct points_point){ .variables = space->variables, .constraints = r->constraints, .certified = true };
    p->x = sga_calloc((size_t)space->variables + 1, sizeof *p->x);
    p->parameter = sga_calloc((size_t)space->parameters + 1, sizeof *p->parameter);
    p->solved = sga_calloc((size_t)r->constraints + 1, sizeof *p->solved);
    num_ball_init(&p->ball, space->st, POINTS_BITS);
    choose_free(r, p);
    return solve_pivots(r, p);
}

bool affine_final_points(struct affine_run *r)
{
    struct state *s = r->s;
    struct sga_error before = *s->err;
    if (affine_sample(s, s->sol->constraints))
        return true;
    if (s->err->code != SGA_E_NO_REAL_POINT || r->many)
        return false;
    points_oracle_forget(s->oracle);
    bool ok = true;
    for (int k = 0; k < POINTS_REAL && ok; k++) {
        ok = exact_point(r, s->oracle->real + k);
        s->oracle->reals++;
    }
    if (ok)
        *s->err = before;
    else
        points_oracle_forget(s->oracle);
    return ok;
}
