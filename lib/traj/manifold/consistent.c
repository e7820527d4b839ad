/* Consistent initial values: the point of the final set nearest to the guess, tier by tier. */
#include "consistent.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ball.h"
#include "budget.h"
#include "error.h"
#include "manifold.h"
#include "mem.h"
#include "print.h"
#include "reduction.h"
#include "seeds.h"
#include "set_points.h"
#include "signals.h"
#include "sizes.h"
#include "system.h"
#include "tiers.h"

/* Dense steps: that many variables, and that many operations for a factorisation. */
enum { MOST = 100, FEW_STARTS = 4 };
static const double DEAR = 1e7, HUGE_NUMBER = 1e300;

/* Whether all constraints have values at the guess, in numbers of any size. */
static bool has_values(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq)
{
    struct num_ball b;
    bool all = true;
    num_ball_init(&b, sys->store, 64);
    for (int j = 0; j < sys->variables; j++)
        num_ball_set_d(&b, sys->variable[j].symbol, rq->initial[j]);
    num_ball_set_d(&b, sys->time, rq->start);
    signals_set(sys, rq->start, &b);
    num_ball_extend(&b);
    for (int i = 0; i < sol->constraints && all; i++)
        all = arb_is_finite(num_ball_value(&b, sol->constraint[i].expr));
    num_ball_clear(&b);
    return all;
}

/* Whether they hold at a point with numbers that no double has (s = cosh(10^6 x)). */
static bool beyond_double(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq)
{
    double *value = set_points_tables(sys, rq->start);
    bool beyond = false;
    struct set_points on;
    struct points_point p;
    uint64_t random = SGA_SEED_MOTION_START;
    set_points_init(&on, sys, sol, sol->constraints, 0, 0);
    on.space.near = rq->initial;
    on.space.near_time = rq->start;
    on.space.by_shape = true;
    on.space.starts = FEW_STARTS;
    on.space.parameter_value = value;
    on.space.budget = rq->budget;
    if (points_find(&on.space, 0, &random, 64, &p) == POINTS_OK)
        for (int j = 0; j < sys->variables; j++)
            beyond |= !isfinite(p.x[j]) || fabs(p.x[j]) > HUGE_NUMBER;
    points_point_clear(&p);
    set_points_clear(&on);
    free(value);
    return beyond;
}

bool consistent_too_large(struct sga_error *err)
{
    return sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial",
                       "the initial values cannot be projected: a constraint has a value or a slope there that is too large for numbers in double; start "
                       "elsewhere, or write the equations without a name for what is so large");
}

static bool refuse(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, int worst, double residual,
                   bool held, struct sga_error *err)
{
    char *text = expr_text(sys->store, worst < 0 ? EXPR_UNDEF : sol->constraint[worst].expr, 300);
    int g = worst >= 0 ? sol->constraint[worst].generation : 0;
    if (residual < 0 && (has_values(sys, sol, rq) || beyond_double(sys, sol, rq)))
        consistent_too_large(err);
    else if (residual < 0)
        sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial",
                    "the initial values cannot be projected: the constraints have no value there; start inside their domain");
    else
        sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial",
                    "the initial values cannot be projected onto the final constraint set%s: the constraint %s = 0 "
                    "(number %d, generation %d) is left with the residual %.3g; change initial%s",
                    held ? " with the held values" : "", text, worst + 1, g, residual, held ? " or hold" : "");
    memcpy(err->stage, "initial", 8);
    free(text);
    return false;
}

/* What was held is what it was, to the last digit. */
static bool held_stay(const struct traj_request *rq, int n, const double *x)
{
    bool stay = true;
    for (int j = 0; j < n && rq->held && stay; j++)
        stay = !rq->held[j] || x[j] == rq->initial[j];
    return stay;
}

bool consistent_start(struct manifold *m, const struct sys_system *sys, const struct sga_solution *sol,
                      const struct sizes *sizes, const struct traj_request *rq, const double *elsewhere, double *x, double *moved, struct sga_error *err)
{
    int n = m->n, worst = -1;
    double residual = 0;
    memcpy(x, rq->initial, (size_t)n * sizeof *x);
    *moved = 0;
    if (m->c == 0)
        return true;
    if (manifold_project(m, rq->start, x, NULL, rq->held, 0, NULL, &residual, NULL))
        return true;          /* on it already */
    bool small = n <= MOST && (double)m->c * m->c * n <= DEAR, any_held = false;
    bool ok = small ? tiers_start(m, sys, sizes, rq, elsewhere, x)
              : (!elsewhere && tiers_large_start(m, sys, sizes, rq, x)) || consistent_large(m, sizes, rq, elsewhere, x);
    double *scale = sga_malloc((size_t)(n + 1) * sizeof *scale);
    for (int j = 0; j < n; j++) {
        scale[j] = sizes_move(sizes, j, rq->initial[j]);
        any_held |= rq->held && rq->held[j];
    }
    if (ok)
        *moved = consistent_moved(m, rq, scale, x);
    if (!ok && err) {       /* what is missing at the guess, the best that can be said */
        memcpy(x, rq->initial, (size_t)n * sizeof *x);
        for (int j = 0; j < n; j++)
            scale[j] *= rq->given[j] ? 1 : 1e3;
        manifold_project(m, rq->start, x, scale, rq->held, 60, NULL, &residual, &worst);
        if (sga_budget_ok(rq->budget, NULL))
            refuse(sys, sol, rq, worst, residual, any_held, err);
    }
    free(scale);
    assert(!ok || (*moved >= 0 && held_stay(rq, n, x)));
    return sga_budget_ok(rq->budget, err) && ok;      /* past a limit the search was not finished, whatever it found */
}
