/* Points of W where the rank of H drops: by Newton's steps from random starts, on W with more equations. */
#include "drops.h"
#include "reduction.h"
#include "seeds.h"
#include "set_points.h"
#include "warnings.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "form.h"
#include "mem.h"

enum { STARTS = 4, BITS = 128 };

static void keep_point(struct mech_search *s, const struct points_point *p, bool certified, int rank, int augmented)
{
    struct mech_regularity *r = s->r;
    r->point = sga_malloc((size_t)(2 * s->n + 1) * sizeof *r->point);
    memcpy(r->point, p->x, (size_t)(2 * s->n) * sizeof *r->point);
    r->t = p->t;
    r->certified = certified;
    r->rank = rank;
    r->augmented = augmented;
    r->full = certified ? MECH_DROPS : MECH_DROP_SUSPECTED;
}

static double value_of(struct num_ball *ball, expr_id e)
{
    return fabs(arf_get_d(arb_midref(num_ball_value(ball, e)), ARF_RND_NEAR));
}

/* The symbols of a place that Newton's steps came near; false where it does not lie on the set,
 * each function being measured by the largest part that it is made of. */
static bool place(const struct mech_search *s, const struct points_space *space, const struct points_point *p, struct num_ball *ball)
{
    bool on = true;
    num_ball_init(ball, s->st, BITS);
    for (int i = 0; i < space->variables; i++) {
        num_ball_set_d(ball, space->variable[i], p->x[i]);
        on = on && fabs(p->x[i]) < 1e6;
    }
    for (int i = 0; i < space->parameters; i++)
        num_ball_set_d(ball, space->parameter[i], p->parameter[i]);
    num_ball_set_d(ball, space->time, p->t);
    num_ball_extend(ball);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < space->constraints && on; i++) {
        double size = 0;
        expr_cone_of(s->st, &cone, space->constraint + i, 1);
        for (int k = 0; k < cone.count; k++)
            size = fmax(size, value_of(ball, cone.list[k]));
        on = value_of(ball, space->constraint[i]) <= fmax(1e-8 * size, 1e-12);
    }
    return on;
}

/* What is looked for on a set. */
enum aim { RANK_OF_H, RANK_OF_WHOLE, ANY_POINT };

/* Looks for a point of the set at which the rank is less than it should be. */
static bool drops_on(struct mech_search *s, const struct points_space *space, double spread, uint64_t *random, const int *end, int stages,
                     enum aim aim)
{
    SGA_ENDS(points_point_clear) struct points_point p;
    enum points_status status = points_find_staged(space, end, stages, spread, random, BITS, &p);
    struct num_ball ball = { 0 }, *at = NULL;
    double tolerance = status == POINTS_OK ? 1e-10 : 1e-5;
    if (status == POINTS_OK) {
        num_ball_forget(&p.ball);
        at = &p.ball;
    } else if (status == POINTS_IRREGULAR && place(s, space, &p, &ball)) {
        at = &ball;
    }
    int rank = s->m, augmented = s->m;
    if (at)
        mech_ranks_at(s, at, tolerance, &rank, &augmented);
    bool found = at && (rank < s->m || aim == ANY_POINT
                        || (aim == RANK_OF_WHOLE && mech_whole_rank_at(s, at, tolerance) < s->n + s->m));
    bool certified = status == POINTS_OK && p.certified;
    if (found && (!s->r->point || (certified && !s->r->certified))) {
        free(s->r->point);
        keep_point(s, &p, certified, rank, augmented);
    }
    if (at == &ball || status == POINTS_IRREGULAR)
        num_ball_clear(&ball);
    return found;
}

/* The set W with room for more functions and variables; near: of as many, the caller frees it. */
static void extend(const struct mech_search *s, int variables, int functions, struct set_points *on, double **near)
{
    *near = sga_calloc((size_t)(2 * s->n + variables) + 1, sizeof **near);
    if (s->options->near)
        memcpy(*near, s->options->near, (size_t)(2 * s->n) * sizeof **near);
    set_points_init(on, &s->f->kinematics, s->f->W, s->f->W->constraints, variables, functions);
    on->space.near = s->options->near ? *near : NULL;
    on->space.near_time = s->options->near_time;
    on->space.budget = s->options->budget;
}

void mech_search_factors(struct mech_search *s)
{
    int c = s->f->W->constraints;
    SGA_FREED double *near = NULL;
    SGA_ENDS(set_points_clear) struct set_points on;
    uint64_t random = SGA_SEED_DROPS;
    extend(s, 0, 1, &on, &near);
    if (s->factors > SGA_MOST_RANK_FACTORS)
        sga_limit_met(s->options->budget, SGA_LIMIT_RANK_FACTORS);
    int own = s->factors < SGA_MOST_RANK_FACTORS ? s->factors : SGA_MOST_RANK_FACTORS, all = own + s->f->W->branches;
    for (int k = 0; k < all && c < 2 * s->n; k++) {
        on.constraint[c] = k < own ? s->factor[k] : s->f->W->branch[k - own].expr;    /* W is no manifold where branches meet */
        on.space.constraints = on.end[on.stages] = c + 1;
        if (drops_on(s, &on.space, on.space.near ? 0.2 : 1, &random, on.end, on.stages + 1, k < own ? RANK_OF_H : ANY_POINT)) {
            s->r->where = sga_realloc(s->r->where, (size_t)(s->r->wheres + 1) * sizeof *s->r->where);
            s->r->where[s->r->wheres++] = on.constraint[c];
        }
    }
}

/* c_1, ..., c_m under names that no request can have. */
static int add_unit(struct mech_search *s, int i)
{
    char name[32];
    snprintf(name, sizeof name, "%d*", i + 1);
    expr_symbol_add(s->st, name, EXPR_VARIABLE);
    return expr_symbol_find(s->st, name, strlen(name));
}

/* c^T H = 0; or, where the masses may fail too, M v = H^T c and H v = 0. The symbols of c
 * and v come last among the variables. Returns how many equations. */
static int kernel_equations(const struct mech_search *s, const int *unit, expr_id *con)
{
    struct expr_store *st = s->st;
    int added = 0;
    for (int j = 0; j < s->n; j++) {
        expr_id sum = expr_int(st, 0);
        for (int i = 0; i < s->m; i++)
            sum = expr_sub(st, sum, expr_mul(st, st->symbol[unit[i]].node, mech_entry(s, i, j)));
        for (size_t k = 0; k < s->in->masses && !s->simple; k++)
            if (s->in->mass[k].row == j)
                sum = expr_add(st, sum, expr_mul(st, s->in->mass[k].value, st->symbol[unit[s->m + s->in->mass[k].col]].node));
        if (!expr_is_zero(st, sum))
            con[added++] = sum;
    }
    for (int i = 0; i < s->m && !s->simple; i++) {
        con[added] = expr_int(st, 0);
        for (int j = 0; j < s->n; j++)
            con[added] = expr_add(st, con[added], expr_mul(st, mech_entry(s, i, j), st->symbol[unit[s->m + j]].node));
        added++;
    }
    assert(added <= s->n + s->m);
    return added;
}

void mech_search_kernels(struct mech_search *s)
{
    struct expr_store *st = s->st;
    int n = s->n, units = s->m + (s->simple ? 0 : n), c = s->f->W->constraints;
    expr_id norm = expr_int(st, -1);
    SGA_FREED double *near = NULL;
    SGA_ENDS(set_points_clear) struct set_points on;
    uint64_t random = SGA_SEED_DROPS_AGAIN;
    extend(s, units, n + s->m + 1, &on, &near);
    for (int i = 0; i < units; i++) {
        on.variable[2 * n + i] = add_unit(s, i);
        norm = expr_add(st, norm, expr_powi(st, st->symbol[on.variable[2 * n + i]].node, 2));
    }
    int total = c + kernel_equations(s, on.variable + 2 * n, on.constraint + c);
    on.constraint[total++] = norm;
    on.space.variables = 2 * n + units;
    on.space.constraints = on.end[on.stages] = total;
    bool found = on.space.constraints > on.space.variables;      /* nothing to look for: W itself is points */
    for (int k = 0; k < STARTS && !found; k++) {
        if (k >= STARTS / 2)
            on.space.near = NULL;
        found = drops_on(s, &on.space, on.space.near ? 0.2 * (k + 1) : 1 + k, &random, on.end, on.stages + 1,
                         s->simple ? RANK_OF_H : RANK_OF_WHOLE);
    }
}
