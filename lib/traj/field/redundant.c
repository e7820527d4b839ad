/* Given equations that the reduction took for consequences, at points of a motion. */
#include "redundant.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "jacobian.h"
#include "mem.h"
#include "seeds.h"
#include "set_points.h"
#include "sides.h"
#include "system.h"
#include "tape.h"

/* Times the error allowed. Below it nothing is said; above the second something is, where balls cannot tell. */
static const double DOUBT = 10, SURE = 1e3;
/* Of the size of what is added up in the equation: what the point of the constraints may be away, and what is surely no rounding. */
static const double NEARBY = 1e-6, LARGE = 1e-6;

static bool has_switches(const struct expr_store *st, expr_id e)
{
    struct expr_cone cone;
    bool has = false;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    for (int k = 0; k < cone.count && !has; k++)
        has = points_switches(expr_op_of(st, cone.list[k]));
    expr_cone_clear(&cone);
    return has;
}

/* One of the constraints, or what one has replaced by algebra. */
static bool is_constraint(const struct given *g, expr_id e)
{
    struct expr_store *st = g->sys->store;
    expr_id other = expr_neg(st, e);
    bool plain = !has_switches(st, e);
    for (int i = 0; i < g->sol->constraints; i++) {
        const struct sga_constraint *c = g->sol->constraint + i;
        bool exact = plain && c->replaced && !c->near_point && !c->chosen;
        if (c->expr == e || c->expr == other || (exact && (c->replaced == e || c->replaced == other)))
            return true;
    }
    return expr_is_zero(st, e);
}

static void add(struct given *g, expr_id e, int row)
{
    if (is_constraint(g, e))
        return;
    g->equation[g->count] = e;
    g->row[g->count++] = row;
}

bool given_init(struct given *g, const struct sys_system *sys, const struct sga_solution *sol, const struct num_switches *w, const double *unit,
                const struct sga_budget *budget, struct sga_error *err)
{
    int n = sys->variables;
    size_t most = (size_t)(sys->rows + sys->restrictions) + 1;
    *g = (struct given){ .sys = sys, .sol = sol, .unit = unit, .budget = budget, .broken = -1, .lost = -1 };
    g->equation = sga_malloc(most * sizeof *g->equation);
    g->row = sga_malloc(most * sizeof *g->row);
    for (int i = 0; i < sys->rows; i++)
        if (!sys->row[i].entries)
            add(g, sys->row[i].alpha, i);
    for (int i = 0; i < sys->restrictions; i++)
        add(g, sys->restriction[i], sys->rows + i);
    if (!g->count)
        return true;
    int *inputs = sga_malloc((size_t)(n + 1) * sizeof *inputs);
    for (int j = 0; j < n; j++)
        inputs[j] = sys->variable[j].symbol;
    inputs[n] = sys->time;
    g->tape = num_tape_new_switched(sys->store, w, g->equation, g->count, inputs, n + 1, err);
    free(inputs);
    if (!g->tape)
        return false;
    g->jac = num_jacobian_new(g->tape, NULL, 0);
    g->in = sga_malloc((size_t)(n + 1) * sizeof *g->in);
    g->value = sga_malloc((size_t)g->count * sizeof *g->value);
    g->slope = sga_malloc((size_t)(g->jac->nnz + 1) * sizeof *g->slope);
    g->rounding = sga_calloc(2 * (size_t)g->count, sizeof *g->rounding);
    g->held = g->rounding + g->count;
    return true;
}

void given_sides(struct given *g, const signed char *side)
{
    if (g->jac)
        num_jacobian_hold(g->jac, side);
}

void given_clear(struct given *g)
{
    num_jacobian_free(g->jac);
    num_tape_free(g->tape);
    free(g->equation);
    free(g->row);
    free(g->in);
    free(g->value);
    free(g->slope);
    free(g->rounding);
    *g = (struct given){ 0 };
}

static bool is_near(const struct given *g, const struct points_point *p)
{
    for (int j = 0; j < g->sys->variables; j++)
        if (!(fabs(p->x[j] - g->in[j]) <= NEARBY * (g->unit[j] + fabs(g->in[j]))))
            return false;
    return true;
}

/* The equation at a point of the constraints near g->in: 1 holds, 0 does not, -1 not known. */
static int proved(struct given *g, expr_id e)
{
    const struct sys_system *sys = g->sys;
    int holds = -1;
    double t = g->in[sys->variables], *value = set_points_tables(sys, t);
    struct set_points on;
    struct points_point p;
    set_points_init(&on, sys, g->sol, g->sol->constraints, 0, 0);
    on.space.parameter_value = value;
    on.space.near = g->in;
    on.space.near_time = t;
    on.space.starts = 1;
    on.space.budget = g->budget;
    struct expr_cone cone;
    uint64_t random = SGA_SEED_REDUNDANT;
    expr_cone_init(&cone);
    if (points_find(&on.space, 0, &random, POINTS_BITS, &p) == POINTS_OK && p.certified && is_near(g, &p)) {
        expr_cone_of(sys->store, &cone, &e, 1);
        num_ball_list(&p.ball, cone.list, cone.count);
        arb_srcptr v = num_ball_value(&p.ball, e);
        holds = arb_is_finite(v) ? arb_contains_zero(v) : -1;
    }
    points_point_clear(&p);
    expr_cone_clear(&cone);
    set_points_clear(&on);
    free(value);
    return holds;
}

/* |value| of equation k that errors of this scale explain, and what its terms add up to. */
static double explained(const struct given *g, int k, const double *scale, double *size)
{
    double sum = 0;
    *size = 0;
    for (int q = g->jac->start[k]; q < g->jac->start[k + 1]; q++) {
        int j = g->jac->col[q];
        double slope = fabs(g->slope[q]);
        if (j < g->sys->variables && isfinite(slope)) {
            sum += slope * scale[j];
            *size += slope * fabs(g->in[j]);
        }
    }
    return sum;
}

static bool holds(struct given *g, int k, const double *scale)
{
    double v = fabs(g->value[k]), size, sum;
    if (v <= g->rounding[k])
        return true;
    sum = explained(g, k, scale, &size);
    if (v <= DOUBT * sum)
        return true;
    if (!isfinite(v))
        return true;            /* beyond the domain: the field says so, or its denominators */
    int proof = proved(g, g->equation[k]);
    bool fine = proof == 1 || (proof < 0 && !(v > SURE * sum && v > LARGE * size));
    if (fine && v <= LARGE * size)
        g->rounding[k] = 2 * v;         /* asked again where it has doubled */
    return fine;
}

bool given_hold(struct given *g, double t, const double *x, const double *scale)
{
    int n = g->sys->variables;
    g->broken = -1;
    if (!g->count)
        return true;
    memcpy(g->in, x, (size_t)n * sizeof *x);
    g->in[n] = t;
    num_jacobian_eval(g->jac, g->in, g->value, g->slope);
    for (int k = 0; k < g->count && g->broken < 0; k++)
        if (!holds(g, k, scale))
            g->broken = k;
        else if (isfinite(g->value[k]))
            g->held[k] = fabs(g->value[k]);
    if (g->broken < 0)
        return true;
    if (g->broken != g->lost || fabs(g->value[g->broken]) > g->far_value) {
        g->far_t = t;
        g->far_value = fabs(g->value[g->broken]);
    }
    g->lost = g->broken;
    g->lost_t = t;
    g->lost_value = fabs(g->value[g->broken]);
    return false;
}

double given_late(const struct given *g, double t)
{
    bool nearer = g->lost_value < 0.5 * g->far_value;
    double here = nearer ? fmax(g->held[g->lost], g->lost_value) : g->held[g->lost], rise = g->far_value - here;
    return rise > 0 ? here * fabs(g->far_t - t) / rise : 0;
}

void given_name(const struct given *g, int k, char *text, size_t size)
{
    assert(k >= 0 && k < g->count);
    int i = g->row[k];
    if (i < g->sys->rows)
        snprintf(text, size, "%s", g->sys->row[i].source);
    else
        snprintf(text, size, "restrict[%d]", i - g->sys->rows);
}
