/* Other parts of the constraint set. Constraints of which none is a product may still have a
 * union of sets as their common zeros (x y = 0 and x z = 0; x M = 0: x = 0, or det M = 0). Points
 * are taken on one part, and what was found to vanish there is not sure to vanish on another: a
 * point found from a far start where it does not is the sign of one, where all that was given holds
 * there. A search, no proof that there is no other. */
#include "strata_listing.h"

#include <assert.h>
#include <string.h>

#include "mem.h"
#include "oracle.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "sides.h"
#include "stratum.h"

enum { STARTS = 5, MORE_STARTS = 16 };

/* Whether the function is 0 at the points of the part that was solved. */
static bool holds_here(struct points_oracle *s, expr_id e)
{
    num_ball_extend(&s->real[0].ball);
    return arb_contains_zero(num_ball_value(&s->real[0].ball, e));
}

/* A function among the first so many that the reduction took for 0, and that is not at p. */
static bool broken_at(struct points_oracle *s, struct points_point *p, int zeros)
{
    assert(zeros <= s->zeros);       /* the list only grows */
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
    const struct sys_system *sys = &j->request->system;
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
    struct strata_look look = { .c = j->solution->constraints, .factor = e, .starts = 1, .far = true, .from = p, .point_only = true };
    bool met = strata_look_at(j, look, &q, &rank) == POINTS_OK && q.certified && !violated(j, &q);
    points_point_clear(p);
    *p = q;
    return met;
}

/* A point of the constraints that leave an equation open, where that does not hold. */
struct excess { double *x, time; expr_id equation; };

/* The constraints are fewer than the functions that vanish: their common zeros may have a part more (w = x = 0 of w y = x^2, w z = x y, the cone
 * with x z = y^2 too), of which no point but those on the cone satisfies the equations. */
static void keep_excess(struct job *j, struct points_point *p, struct excess *e)
{
    size_t n = (size_t)j->request->system.variables;
    const struct sga_solution *sol = j->solution;
    bool here = !e->x && points_on_sides(j->request->system.store, &p->ball, sol->side, sol->sides);    /* beyond, strata of kind side speak */
    expr_id open = here ? violated(j, p) : EXPR_UNDEF;
    if (!open || !arb_is_finite(num_ball_value(&p->ball, open)))
        return;
    e->x = memcpy(sga_malloc(n * sizeof *e->x), p->x, n * sizeof *e->x);
    e->time = p->t;
    e->equation = open;
}

static void list_excess(struct job *j, struct excess *e)
{
    struct sga_buf text = { 0 };
    char *equation = expr_text(&j->request->store, e->equation, 300);
    sga_buf_printf(&text, "the printed constraints have these zeros too, but %s is not 0 here, which the equations ask: no solution passes; the "
                   "admissible points are those near which the constraints have the given equations as their consequence", equation);
    strata_add(j, EXPR_UNDEF, -1, (struct stratum){ .kind = "excess", .point = e->x, .time = e->time, .description = sga_buf_take(&text) });
    free(equation);
}

/* From the k-th random start: a point of another part. */
static bool found(struct job *j, uint64_t k, int zeros, struct points_point *p, struct excess *e)
{
    const struct sga_solution *sol = j->solution;
    struct strata_look look = { .c = sol->constraints, .starts = 1, .seed = k, .far = true, .point_only = true };
    int rank;
    if (strata_look_at(j, look, p, &rank) != POINTS_OK || !p->certified || !broken_at(j->oracle, p, zeros))
        return false;
    keep_excess(j, p, e);
    return meet(j, p) && broken_at(j->oracle, p, zeros) && points_on_sides(j->request->system.store, &p->ball, sol->side, sol->sides);
}

/* Given equations without derivatives, and restrictions, of which some are no constraints of their own: they follow from the others
 * on the part that was solved, perhaps not elsewhere. */
static bool open_equations(const struct job *j)
{
    const struct sys_system *sys = &j->request->system;
    int given = sys->restrictions, first = 0;
    for (int i = 0; i < sys->rows; i++)
        given += !sys->row[i].entries;
    while (first < j->solution->constraints && j->solution->constraint[first].generation == 1)
        first++;
    return given > first;
}

static void list_part(struct job *j, const double *x, double t)
{
    struct stratum as = { .kind = "branch", .description = strdup("another part of the constraint set: functions that vanish on the "
                          "part that was solved do not vanish here, so that its answer is another one; give trajectory.initial near it") };
    size_t n = (size_t)j->request->system.variables;
    as.point = memcpy(sga_malloc(n * sizeof *as.point), x, n * sizeof *as.point);
    as.time = t;
    strata_add(j, EXPR_UNDEF, -1, as);
}

/* Those that the reduction knows of (reduction.h); where it was told where to look, a search. */
void strata_components(struct listing *l)
{
    struct job *j = l->j;
    for (int i = 0; i < j->solution->elsewheres && !j->place.on_part; i++)
        list_part(j, j->solution->elsewhere[i].x, j->solution->elsewhere[i].t);
    if (j->solution->elsewheres)
        return;
    struct points_oracle *s = j->oracle;
    int zeros = s->zeros;
    bool done = !s->reals || !zeros || !j->solution->constraints || j->place.on_part;
    struct excess excess = { 0 };
    uint64_t starts = open_equations(j) ? MORE_STARTS : STARTS;
    for (uint64_t k = 1; k <= starts && !done && job_has_left(j); k++) {
        struct points_point p;
        done = found(j, k, zeros, &p, &excess);
        if (done)
            list_part(j, p.x, p.t);
        points_point_clear(&p);
    }
    if (excess.x)
        list_excess(j, &excess);
}
