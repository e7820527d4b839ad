/* A point of the final set for a linearization. */
#include "linear_place.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "natural.h"
#include "points.h"
#include "reduction.h"
#include "seeds.h"
#include "set_points.h"
#include "system.h"
#include "table_balls.h"
#include "value.h"

/* A fraction stands for a double within this, relative to 1 and itself: what Newton's method leaves of a consistent start. A value that is
 * far from all of them is not moved. */
static const double ROUNDING = 1e-13;
/* Of a point that was given to so many digits another one is not the same any more. */
static const double SAME = 1e-6;
/* Beside 1 + itself: what roundings of tables may move a point by. */
static const double NEAR = 0x1p-40;
enum { MOST_DENOMINATOR = 1000, DIGITS = 12 };

/* The fraction with a small denominator, or the decimal of few digits, that v stands for. */
static bool simple_number(fmpq_t out, double v)
{
    for (int q = 1; q <= MOST_DENOMINATOR; q++) {
        double p = nearbyint(v * q);
        if (fabs(p) < 0x1p52 && fabs(v - p / q) <= ROUNDING * fmax(1, fabs(v)) && (p != 0 || v == 0 || q == 1)) {
            fmpq_set_si(out, (slong)p, (ulong)q);
            return true;
        }
    }
    double scale = pow(10, DIGITS), p = nearbyint(v * scale);
    if (!(fabs(p) < 0x1p52) || p / scale != v)
        return false;
    fmpq_set_si(out, (slong)p, (ulong)scale);
    return true;
}

static expr_id number(struct expr_store *st, double v)
{
    SGA_ENDS(fmpq_end) fmpq_t q = { { 0, 1 } };
    return simple_number(q, v) ? expr_fmpq(st, q) : EXPR_UNDEF;
}

/* The values that were given where the start is at them, short numbers elsewhere. False: some value is none. */
static bool set_exact(struct linear_place *p, const struct sys_system *sys, const struct linear_guess *g)
{
    p->map = sga_zeros(&p->mem, (size_t)p->st->symbols + 1, sizeof *p->map);
    for (int j = 0; j < sys->variables; j++) {
        expr_id given = g->exact ? g->exact[j] : EXPR_UNDEF;
        bool stayed = given && expr_is_const(p->st, given)
                      && fabs(expr_nearest_double(expr_const_value(p->st, given)) - g->x[j]) <= ROUNDING * fmax(1, fabs(g->x[j]));
        if (!(p->map[sys->variable[j].symbol] = stayed ? given : number(p->st, g->x[j])))
            return false;
    }
    return (p->map[sys->time] = number(p->st, g->t)) != EXPR_UNDEF;
}

/* Whether all functions are the constant 0 with the exact values put in. */
static bool vanish(const struct linear_place *p, const expr_id *e, int count)
{
    struct sga_error before = *p->st->error;
    SGA_FREED expr_id *root = sga_malloc(((size_t)count + 1) * sizeof *root);
    bool all = true;
    if (count)
        memcpy(root, e, (size_t)count * sizeof *root);
    expr_substitute(p->st, root, count, p->map);
    all = expr_store_ok(p->st);
    *p->st->error = before;
    for (int i = 0; i < count && all; i++)
        all = expr_is_zero(p->st, root[i]);
    return all;
}

/* Values of tables at the time, and of symbols that have no value at all. Where a table has none but in double, nothing is proved. */
static void set_parameters(struct linear_place *p, const struct sys_system *sys)
{
    SGA_ENDS(arb_end) arb_t v = { 0 };
    for (int i = 0; i < sys->parameters; i++) {
        const struct expr_symbol *s = p->st->symbol + sys->parameter[i];
        arb_zero(v);
        if (s->table && !num_table_around(v, s->table, s->order, p->ball.symbol + sys->time, LINEAR_BITS))
            p->basis = LINEAR_NUMERIC;
        num_ball_set(&p->ball, sys->parameter[i], v);
    }
}

/* Whether a ball is not the double, as far as a double-double tells. */
static bool rounded(arb_srcptr v, double d)
{
    SGA_ENDS(arb_end) arb_t off = { 0 };
    SGA_ENDS(mag_end) mag_t m = { 0 };
    arb_set_d(off, d);
    arb_sub(off, off, v, LINEAR_BITS);
    arb_get_mag(m, off);
    return !(mag_get_d(m) <= 0x1p-90 * (1 + fabs(d)));
}

/* A point was found by doubles of tables. Where the functions have one that is more than its double, the point is no more than near to theirs. After
 * set_parameters. */
static void by_rounded_tables(struct linear_place *p, const struct sys_system *sys, const expr_id *e, int count)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_ENDS(mag_end) mag_t room = { 0 };
    bool any = false;
    expr_cone_init(&cone);
    expr_cone_of(p->st, &cone, e, count);
    for (int k = 0; k < cone.count && !any; k++) {
        const struct expr_node *n = p->st->node + cone.list[k];
        const struct expr_symbol *s = n->op == EXPR_SYM ? p->st->symbol + n->a : NULL;
        any = s && s->table && rounded(p->ball.symbol + n->a, expr_table_value(s->table, s->order, p->t));
    }
    for (int j = 0; j < sys->variables && any; j++) {
        mag_set_d(room, NEAR * (1 + fabs(p->x[j])));
        arb_add_error_mag(p->ball.symbol + sys->variable[j].symbol, room);
        p->basis = LINEAR_NUMERIC;
    }
}

static bool take_exact(struct linear_place *p, const struct sys_system *sys, const struct linear_guess *g)
{
    SGA_ENDS(arb_end) arb_t v = { 0 };
    p->basis = LINEAR_EXACT;
    for (int j = 0; j <= sys->variables; j++) {
        int symbol = j < sys->variables ? sys->variable[j].symbol : sys->time;
        const fmpq *q = expr_const_value(p->st, p->map[symbol]);
        arb_set_fmpq(v, q, LINEAR_BITS);
        num_ball_set(&p->ball, symbol, v);
        if (j < sys->variables)
            p->x[j] = expr_nearest_double(q);
    }
    p->t = g->t;
    set_parameters(p, sys);
    return true;
}

/* What is not told from 0, and is less than this of the largest value, is 0: roundings of the search. */
static const double NOTHING = 0x1p-120;

static void drop_roundings(struct linear_place *p, const struct sys_system *sys)
{
    double most = 0;
    for (int j = 0; j < sys->variables; j++)
        most = fmax(most, fabs(p->x[j]));
    for (int j = 0; j < sys->variables; j++)
        if (fabs(p->x[j]) < NOTHING * most && arb_contains_zero(p->ball.symbol + sys->variable[j].symbol))
            p->x[j] = 0;
}

/* From the point that Newton's method found and Krawczyk's proved, if it is the one that was meant. */
static bool take_point(struct linear_place *p, const struct sys_system *sys, const struct linear_guess *g, const int *scale, const struct points_point *point)
{
    for (int j = 0; j < sys->variables; j++)
        if (!(fabs(point->x[j] - g->x[j]) <= SAME * fmax(scale && scale[j] > 0 ? ldexp(1, scale[j]) : 1, fabs(g->x[j]))))
            return false;
    p->map = NULL;
    p->basis = point->certified ? LINEAR_PROVED : LINEAR_NUMERIC;
    for (int j = 0; j < sys->variables; j++) {
        num_ball_set(&p->ball, sys->variable[j].symbol, point->ball.symbol + sys->variable[j].symbol);
        p->x[j] = arf_get_d(arb_midref(p->ball.symbol + sys->variable[j].symbol), ARF_RND_NEAR);
    }
    drop_roundings(p, sys);
    num_ball_set_d(&p->ball, sys->time, g->t);
    p->t = g->t;
    set_parameters(p, sys);
    return true;
}

static bool search(struct linear_place *p, const struct sys_system *sys, const struct sga_solution *sol, const struct linear_guess *g)
{
    struct set_points on;
    struct points_point point;
    uint64_t random = SGA_SEED_MOTION;
    set_points_init(&on, sys, sol, sol->constraints, 0, g->zeros);
    SGA_FREED double *value = set_points_tables(sys, g->t);
    double time;
    SGA_FREED int *scale = natural_sizes(sys, &time);
    on.space.scale = scale;
    for (int k = 0; k < g->zeros; k++)
        on.constraint[on.space.constraints++] = g->zero[k];
    on.space.near = g->x;
    on.space.near_time = g->t;
    on.space.parameter_value = value;
    on.space.starts = 1;
    on.space.budget = g->budget;
    bool found = points_find(&on.space, 0, &random, LINEAR_BITS, &point) == POINTS_OK && take_point(p, sys, g, scale, &point);
    if (found)
        by_rounded_tables(p, sys, on.constraint, on.space.constraints);
    points_point_clear(&point);
    set_points_clear(&on);
    return found;
}

bool linear_place_find(struct linear_place *p, const struct sys_system *sys, const struct sga_solution *sol, const struct linear_guess *g)
{
    *p = (struct linear_place){ .st = sys->store, .t = g->t };
    num_ball_init(&p->ball, p->st, LINEAR_BITS);
    p->x = sga_zeros(&p->mem, (size_t)sys->variables + 1, sizeof *p->x);
    SGA_FREED expr_id *zero = sga_malloc(((size_t)sol->constraints + (size_t)g->zeros + 1) * sizeof *zero);
    for (int i = 0; i < sol->constraints; i++)
        zero[i] = sol->constraint[i].expr;
    for (int k = 0; k < g->zeros; k++)
        zero[sol->constraints + k] = g->zero[k];
    if (set_exact(p, sys, g) && vanish(p, zero, sol->constraints + g->zeros))
        return take_exact(p, sys, g);
    return search(p, sys, sol, g);
}

void linear_place_clear(struct linear_place *p)
{
    num_ball_clear(&p->ball);
    sga_arena_end(&p->mem);
    *p = (struct linear_place){ .st = NULL };
}

/* The constants that expressions are at the exact values, or without any; false: some is none. */
static bool constants(struct linear_place *p, const expr_id *e, int count, struct linear_matrix *out)
{
    struct expr_store *st = p->st;
    struct sga_error before = *st->error;
    SGA_FREED expr_id *root = sga_malloc(((size_t)count + 1) * sizeof *root);
    bool ok = true;
    for (int i = 0; i < count; i++)
        root[i] = e[i] ? e[i] : expr_int(st, 0);
    if (p->map)
        expr_substitute(st, root, count, p->map);
    ok = expr_store_ok(st);
    *st->error = before;
    for (int i = 0; i < count && ok; i++) {
        ok = expr_is_const(st, root[i]);
        if (ok)
            fmpq_set(fmpq_mat_entry(out->q, i / linear_cols(out), i % linear_cols(out)), expr_const_value(st, root[i]));
    }
    return ok;
}

bool linear_place_matrix(struct linear_place *p, const expr_id *e, int rows, int cols, struct linear_matrix *out)
{
    int count = rows * cols;
    linear_matrix_init(out, rows, cols);
    if (constants(p, e, count, out)) {
        linear_matrix_enclose(out);
        return true;
    }
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_ARENA(mem);
    expr_id *root = sga_take(&mem, ((size_t)count + 1) * sizeof *root);
    int roots = 0;
    bool finite = true;
    for (int i = 0; i < count; i++)
        if (e[i])
            root[roots++] = e[i];
    out->exact = false;
    expr_cone_init(&cone);
    expr_cone_of(p->st, &cone, root, roots);
    num_ball_forget(&p->ball);
    num_ball_list(&p->ball, cone.list, cone.count);
    for (int i = 0; i < count; i++) {
        if (!e[i])
            continue;
        arb_set(arb_mat_entry(out->b, i / cols, i % cols), num_ball_value(&p->ball, e[i]));
        finite = finite && arb_is_finite(num_ball_value(&p->ball, e[i]));
    }
    return finite;
}

static bool changes(struct linear_place *p, const struct expr_node *n)
{
    arb_srcptr a = num_ball_value(&p->ball, n->a);
    if (n->op == EXPR_ABS || n->op == EXPR_SIGN)
        return arb_contains_zero(a);
    return (n->op == EXPR_MIN || n->op == EXPR_MAX) && arb_overlaps(a, num_ball_value(&p->ball, n->b));
}

bool linear_place_smooth(struct linear_place *p, const expr_id *e, int count)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(p->st, &cone, e, count);
    num_ball_forget(&p->ball);
    num_ball_list(&p->ball, cone.list, cone.count);
    for (int k = 0; k < cone.count; k++)
        if (changes(p, p->st->node + cone.list[k]))
            return false;
    return true;
}
