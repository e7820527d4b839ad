/* Points on which functions vanish, for the strata: searches within a bound that all of them share, and
 * the rank there. */
#include "strata_listing.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "derive.h"
#include "differentials.h"
#include "lin_rank.h"
#include "oracle.h"
#include "poly.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "set_points.h"
#include "strata_case.h"
#include "warnings.h"

enum { LEAST_STEPS = 30, NEAR_STARTS = 8, FAR_STARTS = 12 };
/* How far from a guess to begin. */
static const double NEAR = 0.2;
/* All searches of an answer together, in steps times nodes: about a second. Each may take a part of what is
 * left, so that no one that finds nothing takes all. Who asks for strata has ten times as much. */
static const double PART = 0.2;
/* rows * columns * the smaller: past it singular values take seconds that nobody could stop, and
 * the rank counts as lower: listed, to be safe */
static const double RANK_WORK = 1e8, RANK = 1e-10;

/* The right side of row i: alpha, or how the constraint changes by time alone, 0 where it does not move. */
static double right_side(struct job *j, const struct points_space *space, int rows, int i, struct points_point *p)
{
    const struct sys_system *sys = &j->request->system;
    expr_id e = i < rows ? sys->row[i].alpha : expr_neg(&j->request->store, expr_diff(&j->request->store, space->constraint[i - rows], sys->time));
    num_ball_extend(&p->ball);
    arb_srcptr v = num_ball_value(&p->ball, e);
    return arb_contains_zero(v) ? 0 : arf_get_d(arb_midref(v), ARF_RND_NEAR);
}

/* The rank of [A; d xi], with the right side as a further column where asked for; the largest entry of each row, and of that column, is 1. */
static int rank_at(struct job *j, const struct points_space *space, int rows, int c, bool right, struct points_point *p)
{
    const struct sys_system *sys = &j->request->system;
    int n = sys->variables, m = rows + c, cols = n + right;
    assert(rows <= sys->rows && c <= space->constraints);
    SGA_ARENA(mem);
    double *M = sga_zeros(&mem, (size_t)(m + 1) * (size_t)cols, sizeof *M);
    double most = 0, bound = 0;
    struct points_space own = *space;
    own.constraints = c;
    own.variables = n;
    struct points_jacobian jac;
    points_jacobian_init(&jac, &own);
    points_jacobian_values(&jac, &p->ball);
    points_jacobian_entries(&jac, &p->ball);
    num_ball_forget(&p->ball);
    num_ball_extend(&p->ball);
    for (int i = 0; i < m; i++) {
        int len = i < rows ? sys->row[i].entries : jac.cols[i - rows];
        double *row = M + (size_t)i * (size_t)cols, big = 0;
        for (int k = 0; k < len; k++) {
            int col = i < rows ? sys->row[i].entry[k].col : jac.col[i - rows][k];
            arb_srcptr v = i < rows ? num_ball_value(&p->ball, sys->row[i].entry[k].value) : jac.entry[i - rows] + k;
            row[col] = arb_contains_zero(v) ? 0 : arf_get_d(arb_midref(v), ARF_RND_NEAR);     /* a row of roundings is no row */
            big = fmax(big, fabs(row[col]));
        }
        if (right)
            row[n] = right_side(j, space, rows, i, p);
        for (int k = 0; k < cols && big > 0; k++)
            row[k] /= big;
        most = right ? fmax(most, fabs(row[n])) : 0;
    }
    for (int i = 0; i < m && most > 0; i++)
        M[(size_t)i * (size_t)cols + (size_t)n] /= most;
    struct lin_dense dense = { .rows = m, .cols = cols, .a = M };
    int rank = 0;
    lin_rank(&dense, RANK, 0, &bound, &rank);
    assert(rank <= m && rank <= cols);
    points_jacobian_clear(&jac);
    return rank;
}

int strata_rank_at(struct job *j, const struct points_space *space, int rows, int c, struct points_point *p)
{
    return rank_at(j, space, rows, c, false, p);
}

/* Newton steps that a search may take on the set of so many functions; 0: no more. */
static long steps_granted(const struct job *j, double cost)
{
    double left = (j->request->strata ? (double)SGA_MOST_STRATA_SOLVING_WORK : SGA_MOST_STRATA_WORK) - j->strata.work, steps = PART * left / cost;
    return left < LEAST_STEPS * cost ? 0 : (long)fmin(fmax(steps, LEAST_STEPS), 1e9);
}

/* Whether no search on the set of the first c constraints is granted a step any more, as was found before: the cone of all of them is not
 * walked for each function to say so again. */
static bool spent(const struct job *j, int c)
{
    return j->strata.spent_on == c + 1 && !steps_granted(j, j->strata.least_cost);
}

/* What one step evaluates: values and derivatives of these functions, and the equations of the step. */
static double step_cost(const struct expr_store *st, const expr_id *con, int c, int variables)
{
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, con, c);
    double cost = cone.count + 20.0 * (c + variables);
    expr_cone_clear(&cone);
    return cost;
}

/* Whether the function has one value, not 0, on all of the final set (x^2 + y^2 on a circle). */
static bool constant_there(struct job *j, expr_id e)
{
    struct points_oracle *s = j->oracle;
    if (s->reals < 2)
        return false;
    num_ball_ask(&s->real[0].ball, e);
    num_ball_ask(&s->real[1].ball, e);
    arb_srcptr v = num_ball_value(&s->real[0].ball, e), other = num_ball_value(&s->real[1].ball, e);
    double d = arf_get_d(arb_midref(v), ARF_RND_NEAR), den = 1;
    if (!arb_is_finite(v) || !arb_overlaps(v, other) || !(fabs(d) < 1e9))
        return false;
    while (den < 1e6 && d * den != nearbyint(d * den))      /* decimals and small denominators */
        den *= den < 3600 ? 60 : 10;
    if (d * den != nearbyint(d * den) || d == 0)
        return false;
    fmpq_t q;
    fmpq_init(q);
    fmpq_set_si(q, (slong)(d * den), (ulong)den);
    expr_id rest = expr_sub(&j->request->store, e, expr_fmpq(&j->request->store, q));
    fmpq_clear(q);
    if (strata_is_constraint(j, rest))      /* a point modulo a prime costs far more */
        return true;
    if (!points_oracle_modular_zero(s, rest))      /* digits would not be enough */
        return false;
    struct points_decision same = points_oracle_zero(s, rest);
    return same.truth == POINTS_ZERO && (same.basis == POINTS_ZERO_ALGEBRAIC || same.basis == POINTS_EXACT);
}

/* Stage by stage from so many starts; those of a guess first, then others anywhere: the stratum may lie on the other side of the
 * set, and a search that finds nothing is to end before its steps do in a small system, in whatever order it was written. */
static enum points_status staged(struct points_space *space, uint64_t seed, const int *end, int stages, struct points_point *p)
{
    uint64_t random = seed;
    if (space->starts || !space->near)
        return points_find_staged(space, end, stages, space->near ? NEAR : 1, &random, 64, p);
    struct points_space from = *space;
    from.starts = NEAR_STARTS;
    enum points_status status = points_find_staged(&from, end, stages, NEAR, &random, 64, p);
    if (status != POINTS_NONE || *space->steps <= 0)
        return status;
    points_point_clear(p);
    from.near = NULL;
    from.starts = FAR_STARTS;
    random = seed;
    return points_find_staged(&from, end, stages, 1, &random, 64, p);
}

/* Within the steps granted, on the set of the first on_set constraints of the space where the others vanish: from the known point of the final set (NULL: none), then stage by stage. */
static enum points_status search(struct job *j, struct points_space *space, int on_set, const struct points_point *known, uint64_t seed,
                                 const int *end, int stages, struct points_point *p)
{
    double spread = space->near ? NEAR : 1, cost = step_cost(space->st, space->constraint, space->constraints, space->variables);
    long granted = steps_granted(j, cost), steps = granted;
    uint64_t random = seed;
    enum points_status status = POINTS_NONE;
    space->steps = &steps;
    if (!granted) {              /* the set alone costs no more than with functions that vanish, too */
        j->strata.least_cost = step_cost(space->st, space->constraint, on_set, j->request->system.variables);
        j->strata.spent_on = on_set + 1;
    }
    if (known && granted) {
        struct points_space from = *space;
        from.before = known;
        from.starts = 3;
        status = points_find(&from, spread, &random, 64, p);
    }
    if (granted && status != POINTS_OK && status != POINTS_STOPPED) {
        points_point_clear(p);
        status = staged(space, seed, end, stages, p);
    }
    j->strata.work += (double)(granted - (steps > 0 ? steps : 0)) * cost;
    if (steps <= 0 && status == POINTS_NONE) {
        sga_limit_met(j->budget, j->request->strata ? SGA_LIMIT_STRATA_SOLVING_WORK : SGA_LIMIT_STRATA_WORK);
        j->strata.skipped = true;
    }
    return status;
}

enum points_status strata_look_at(struct job *j, struct strata_look look, struct points_point *p, int *rank)
{
    int c = look.c;
    expr_id factor = look.factor;
    enum strata_moving moving = look.moving;
    const struct sys_system *sys = &j->request->system;
    int n = sys->variables;
    int fixed = 0;                 /* parameters; tables, listed after them, are any functions and move too */
    while (fixed < sys->parameters && sys->store->symbol[sys->parameter[fixed]].kind == EXPR_PARAMETER)
        fixed++;
    int values = moving == STRATA_PARAMETERS ? 0 : fixed, moved = sys->parameters - values;
    int extra = moved + (moving == STRATA_TIME);
    int more = look.squares ? look.squares : factor != EXPR_UNDEF;
    const struct points_oracle *oracle = j->oracle;
    bool final = factor && !extra && oracle->reals && c == j->solution->constraints && oracle->space.constraints == c
                 && oracle->space.variables == n;
    bool constant = final && !look.from && constant_there(j, factor);
    *p = (struct points_point){ 0 };
    *rank = -1;
    if (look.solvable)
        *look.solvable = false;
    if (!constant && spent(j, c)) {
        sga_limit_met(j->budget, j->request->strata ? SGA_LIMIT_STRATA_SOLVING_WORK : SGA_LIMIT_STRATA_WORK);
        j->strata.skipped = true;
        return POINTS_NONE;
    }
    struct set_points on;
    set_points_init(&on, sys, j->solution, c, extra, more);
    for (int i = 0; i < extra; i++)
        on.variable[n + i] = i < moved ? sys->parameter[values + i] : sys->time;
    for (int i = 0; i < more; i++)
        on.constraint[c + i] = look.squares ? look.squared[i] : factor;
    struct points_space *space = &on.space;
    space->variables += extra;
    space->parameters = values;
    space->time = moving == STRATA_TIME ? -1 : sys->time;
    space->constraints += more;
    space->near = extra || look.far ? NULL : j->start.x;
    space->near_time = j->start.time;
    space->scale = extra ? NULL : j->solution->scale;
    space->starts = look.starts;
    space->by_name = true;
    space->budget = j->budget;
    if (factor)
        on.end[on.stages++] = c + more;
    const struct points_point *known = look.from ? look.from : final ? oracle->real : NULL;
    enum points_status status = constant ? POINTS_NONE : search(j, space, c, known, 5 + look.seed, on.end, on.stages, p);
    double rows = sys->rows + c, work = rows * n * fmin(rows, n);
    *rank = status != POINTS_OK || look.point_only ? -1 : work > RANK_WORK ? 0 : strata_rank_at(j, space, sys->rows, c, p);
    if (look.solvable)
        *look.solvable = *rank > 0 && rank_at(j, space, sys->rows, c, true, p) == *rank;
    set_points_clear(&on);
    return status;
}

int strata_general_rank(struct listing *l, int before)
{
    assert(before <= l->j->solution->constraints);
    struct points_point p;
    if (l->before != before) {
        strata_look_at(l->j, (struct strata_look){ .c = before }, &p, &l->rank);
        points_point_clear(&p);
        l->before = before;
    }
    return l->rank;
}
