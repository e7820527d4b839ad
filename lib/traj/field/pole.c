/* Denominators of the equations as given that change their sign along a motion. x' = x/t, stepped over t = 0, has a
 * value on each side and no solution that goes through: a step sees nothing of the pole between its stages. Where
 * the quotient stays bounded (sin(t)/t), or what the reduction left has no such denominator, the motion goes on;
 * so it does where the field grows slowly enough for the solution to stay continuous by itself (1/cbrt(t)).
 *
 * Which of these holds is asked of points near the place, off the motion: there x/t may look bounded because x
 * tends to 0 on every solution, but not on the ones beside it.
 *
 * What variables are defined as (reduction.h) is no part of the field, and the motion has none where that has no value: at zeros of its denominators and
 * of arguments of logarithms, under abs and roots too (1/abs(x), log(sqrt(x^2 + y^2))), as far as these come with a sign, it ends where a value grows beyond all bounds. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "facts.h"
#include "field.h"
#include "manifold.h"
#include "mem.h"
#include "pole_named.h"
#include "poly.h"
#include "seeds.h"
#include "system.h"
#include "tape.h"
#include "warnings.h"
#include "watch.h"

enum { ASKED = 3, DISTANCES = 3, NEWTON = 12, DOUBLINGS = 4 };
static const double NEAR = 4e-2;                                /* of the same: where a zero is sought from a place beside it */
static const double BESIDE = 1e-2;                              /* of the variables' sizes */
static const double distance[DISTANCES] = { 1e-3, 1e-5, 1e-7 };  /* in the same units */
static const double GROWN = 10;         /* times what the variables were at the start */
static const double LEAST_FALL = 1e-3;  /* of the denominator, where a step is brought back to the constraints */
static const double GROWTH = 20;       /* from one distance to the next: beyond |d|^(-2/3) */
static const double STAYS = 0.5, SEEN = 1e-9;   /* of a value's change from one distance to the next: it has no limit then; changes that are no roundings */
static const double SLOWEST = 1.5, FASTEST = 20, SAME_RATIO = 0.3;       /* of what grows, from a distance to half of it; powers from -2/3 to -4, and logarithms beside them */

/* By expression: whether it is in the list already. */
struct known { unsigned char *in; size_t cap; };

static void add(struct known *known, expr_id e, struct field_list *l)
{
    size_t before = known->cap;
    SGA_RESERVE(known->in, known->cap, e + 1);
    memset(known->in + before, 0, known->cap - before);
    if (!known->in[e])
        field_list_add(l, e);
    known->in[e] = 1;
}

static void add_factors(struct field *f, expr_id denominator, struct known *known, struct field_list *l)
{
    struct poly_limits limits = poly_limits_of(POLY_GLANCE, NULL);
    struct poly_factors q;
    if (!poly_numerator_factors(f->sys->store, denominator, &limits, &q)) {
        add(known, denominator, l);
        return;
    }
    for (int i = 0; i < q.factors; i++)
        if (!q.factor[i].never_zero && !q.factor[i].sum_of_even_powers && q.factor[i].depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME))
            add(known, q.factor[i].expr, l);
    poly_factors_clear(&q);
}

/* Of what is defined: the zeros of |u| and of roots of u are those of u, which has a sign on each side. */
static void add_signed(struct field *f, expr_id e, struct known *known, struct field_list *l)
{
    const struct expr_store *st = f->sys->store;
    struct field_list factors = { 0 };
    struct known here = { 0 };
    add_factors(f, e, &here, &factors);
    for (int i = 0; i < factors.count; i++) {
        enum expr_op op = expr_op_of(st, factors.e[i]);
        if (op == EXPR_ABS || op == EXPR_SQRT || op == EXPR_CBRT || op == EXPR_POW)
            add_signed(f, st->node[factors.e[i]].a, known, l);
        else
            add(known, factors.e[i], l);
    }
    free(factors.e);
    free(here.in);
}

/* Where what variables are defined as may have no value. */
static void find_defined(struct field *f, struct known *known, struct field_list *l)
{
    struct expr_store *st = f->sys->store;
    struct field_list at = { 0 };
    struct known met = { 0 };
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, f->valued, f->valueds);
    for (int i = 0; i < cone.count; i++) {
        enum expr_op op = expr_op_of(st, cone.list[i]);
        expr_id d = op == EXPR_LOG ? st->node[cone.list[i]].a : op == EXPR_TAN ? expr_fun(st, EXPR_COS, st->node[cone.list[i]].a) : expr_divisor(st, cone.list[i]);
        if (d && !expr_is_const(st, d))
            add(&met, d, &at);
    }
    expr_cone_clear(&cone);
    for (int i = 0; i < at.count; i++)
        add_signed(f, at.e[i], known, l);
    free(at.e);
    free(met.in);
}

void field_find_poles(struct field *f, struct field_list *l)
{
    const struct sys_system *sys = f->sys;
    struct field_list watched = { 0 }, divisors = { 0 };
    struct known known = { 0 }, met = { 0 };
    expr_id *root;
    int at = sys_expressions(sys, &root);
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(sys->store, &cone, root, at);
    for (int i = 0; i < cone.count; i++) {
        const struct expr_node e = sys->store->node[cone.list[i]];
        expr_id d = e.op == EXPR_TAN ? expr_fun(sys->store, EXPR_COS, e.a) : expr_divisor(sys->store, cone.list[i]);
        if (d && !expr_is_const(sys->store, d))
            add(&met, d, &divisors);
    }
    expr_cone_clear(&cone);
    free(root);
    for (int i = f->n; i < l->count; i++)
        add(&known, l->e[i], &watched);
    for (int i = 0; i < divisors.count; i++)
        add_factors(f, divisors.e[i], &known, l);
    if (f->valueds)
        find_defined(f, &known, l);
    free(watched.e);
    free(divisors.e);
    free(known.in);
    free(met.in);
}

/* One question: a point z (variables, time), units, the gradient in these units, values of the field. */
struct asked {
    struct field *f;
    struct manifold *on;           /* the constraints, or what is left of them (pole_named.h) */
    int q;
    double *z, *unit, *g, *at, *v[DISTANCES];
    bool told;           /* some question had an answer: there were points to ask at */
};

/* The denominator at in + step * unit * g, projected on the constraints where v is asked for too. */
static bool look(struct asked *a, double step, double *d, double *v)
{
    struct field *f = a->f;
    for (int j = 0; j <= f->n; j++)
        a->at[j] = a->z[j] + step * a->unit[j] * a->g[j];
    if (v && a->on->c && !manifold_project(a->on, a->at[f->n], a->at, NULL, NULL, 8, NULL, NULL, NULL))
        return false;
    memcpy(f->in, a->at, (size_t)(f->n + 1) * sizeof *f->in);
    num_tape_eval(f->direct, f->in, f->direct_out);
    *d = f->direct_out[f->n + f->pivots + a->q];
    return isfinite(*d) && (!v || a->on != f->manifold || field_value(f, v));
}

/* g: the gradient at z, of length 1. False: it has none. */
static bool gradient(struct asked *a, double *slope)
{
    int n = a->f->n;
    double sum = 0, up, down, *g = sga_calloc((size_t)n + 1, sizeof *g);
    bool ok = true;
    for (int j = 0; j <= n && ok; j++) {
        memset(a->g, 0, (size_t)(n + 1) * sizeof *a->g);
        a->g[j] = 1;
        ok = look(a, 1e-6, &up, NULL) && look(a, -1e-6, &down, NULL);
        g[j] = (up - down) / 2e-6;
        sum += g[j] * g[j];
    }
    *slope = sqrt(sum);
    for (int j = 0; j <= n; j++)
        a->g[j] = g[j] / *slope;
    free(g);
    return ok && *slope > 0 && isfinite(*slope);
}

/* z onto the constraints. */
static bool onto_constraints(struct asked *a)
{
    struct manifold *m = a->on;
    return !m->c || manifold_project(m, a->z[a->f->n], a->z, a->unit, NULL, 8, NULL, NULL, NULL);
}

/* z onto a zero of the denominator; `on`: on the constraints: a step down the gradient, brought back to them, goes along the gradient within them; it is made as long
 * as its secant says. */
static bool settle(struct asked *a, bool on)
{
    size_t n = (size_t)a->f->n + 1;
    double slope, d = 1, after, *from = sga_calloc(n, sizeof *from);
    bool found = false, ok = !on || onto_constraints(a);
    for (int turn = 0; turn < NEWTON && ok && !found && sga_watch_ok(); turn++) {
        ok = gradient(a, &slope) && look(a, 0, &d, NULL);
        found = ok && fabs(d) <= 1e-12 * slope;
        if (!ok || found)
            break;
        memcpy(from, a->z, n * sizeof *from);
        for (size_t j = 0; j < n; j++)
            a->z[j] -= d / slope * a->unit[j] * a->g[j];
        if (!on)
            continue;
        ok = onto_constraints(a) && look(a, 0, &after, NULL) && fabs(d - after) > LEAST_FALL * fabs(d);
        for (size_t j = 0; j < n && ok; j++)
            a->z[j] = from[j] + d / (d - after) * (a->z[j] - from[j]);
        ok = ok && onto_constraints(a);
    }
    free(from);
    return found;
}

/* On the constraints where there are any; where they have no point at the zero, as what is divided grows beyond all bounds there, near them. */
static bool find_zero(struct asked *a)
{
    size_t n = (size_t)a->f->n + 1;
    if (!a->on->c)
        return settle(a, false);
    double *from = memcpy(sga_calloc(n, sizeof *from), a->z, n * sizeof *from);
    bool found = settle(a, true);
    if (!found) {
        memcpy(a->z, from, n * sizeof *from);
        found = settle(a, false);
    }
    free(from);
    return found;
}

/* Values of what is defined, or named, where look was last. */
static void values_at(struct asked *a, double *w)
{
    struct field *f = a->f;
    memcpy(f->in, a->at, (size_t)(f->n + 1) * sizeof *f->in);
    if (a->on == f->manifold)
        num_tape_eval(f->values, f->in, w);
    else
        pole_named_values(f->named, f->in, w);
}

/* As steady below, of value i at the least distance and at that doubled, again and again: its changes shrink by one factor, those of a logarithm by 1. */
static bool steady_value(const double *w, int count, int i)
{
    double before = 0, ratio = 0;
    bool ok = true;
    for (int k = 0; k < DOUBLINGS && ok; k++) {
        const double *v = w + (DISTANCES - 1 + k) * count + i;
        double change = v[count] - v[0], now = change / before;
        ratio = k == 1 ? now : ratio;
        ok = k == 0 || (now > 0 && fabs(now - ratio) < SAME_RATIO * ratio);
        before = change;
    }
    return ok;
}

/* Does one of these have no limit towards z from this side? w: count at the distances, and at the least one doubled. */
static bool has_no_limit(struct asked *a, double side, int count, double *w)
{
    double d;
    bool none = false;
    for (int k = 0; k < DISTANCES + DOUBLINGS; k++) {
        double far = k < DISTANCES ? distance[k] : distance[DISTANCES - 1] * (1 << (k - DISTANCES + 1));
        if (!look(a, side * far, &d, a->v[0]))
            return false;
        values_at(a, w + k * count);
    }
    for (int i = 0; i < count && !none; i++) {
        double first = fabs(w[count + i] - w[i]), second = fabs(w[2 * count + i] - w[count + i]);
        none = second > STAYS * first && second > SEEN * fabs(w[2 * count + i]) && steady_value(w, count, i);
    }
    return none;
}

/* How far two values of the field are apart, in units. */
static double apart(const struct asked *a, const double *v, const double *w)
{
    double most = 0;
    for (int j = 0; j < a->f->n; j++)
        most = fmax(most, fabs(v[j] - (w ? w[j] : 0)) / a->unit[j]);
    return most;
}

/* Whether what grows towards z is a power of the distance, and no rounding of what cancels there ((1 - cos(d))/d^2): from the least distance on, doubling it makes the same
 * of it each time. */
static bool steady(struct asked *a, double side)
{
    int n = a->f->n, most = 0;
    const double *far = a->v[1], *near = a->v[2];
    double *v = a->v[0], d, last, ratio = 0;
    for (int j = 1; j < n; j++)
        most = fabs(near[j] - far[j]) / a->unit[j] > fabs(near[most] - far[most]) / a->unit[most] ? j : most;
    last = near[most] - far[most];
    bool ok = n > 0;
    for (int k = 1; k <= DOUBLINGS && ok; k++) {
        ok = look(a, side * distance[DISTANCES - 1] * (1 << k), &d, v);
        double now = v[most] - far[most], fall = last / now;
        ratio = k == 1 ? fall : ratio;
        ok = ok && fall > SLOWEST && fall < FASTEST && fabs(fall - ratio) < SAME_RATIO * ratio;
        last = now;
    }
    return ok;
}

/* Does the field grow towards z from this side? */
static bool grows(struct asked *a, double side)
{
    double d;
    for (int k = 0; k < DISTANCES; k++)
        if (!look(a, side * distance[k], &d, a->v[k]))
            return false;
    a->told = true;
    double first = apart(a, a->v[1], a->v[0]), second = apart(a, a->v[2], a->v[1]);
    return second > GROWTH * first && (second > 0.5 * apart(a, a->v[2], NULL) || steady(a, side));
}

/* The sizes of variables and time, in which near is measured. */
static void units(struct asked *a, const double *y, double t)
{
    const struct field *f = a->f;
    double most = 0, begun = 0;
    for (int j = 0; j < f->n; j++) {
        most = fmax(most, a->unit[j] = fmax(fabs(y[j]), fabs(f->pole_from[j])));
        begun = fmax(begun, fabs(f->pole_from[j]));
    }
    most = begun > 0 ? fmin(most, GROWN * begun) : most;         /* what grows beyond all bounds is no measure of the others */
    for (int j = 0; j < f->n; j++)
        a->unit[j] = most > 0 ? fmax(a->unit[j], 1e-3 * most) : 1;
    a->unit[f->n] = fmax(fabs(t - f->start_t), 1e-300);
}

/* A denominator that jumps over 0, at a switch, has no zero where it changed its sign. */
static bool near_place(const struct asked *a, const double *y, double t)
{
    int n = a->f->n;
    double sum = 0;
    for (int j = 0; j <= n; j++) {
        double far = (a->z[j] - (j < n ? y[j] : t)) / a->unit[j];
        sum += far * far;
    }
    return sum <= NEAR * NEAR * (n + 1);
}

/* Of the way from where the motion is to x, in units. */
static double longest(const struct asked *a, const double *x)
{
    double most = 0;
    for (int j = 0; j < a->f->n; j++)
        most = fmax(most, fabs(x[j] - a->f->home[j]) / a->unit[j]);
    return most;
}

/* On the constraints, by the field and what is defined; or on what is left of them, by what is named. */
static int vote(struct asked *a, const double *y, double at, double *w)
{
    struct field *f = a->f;
    bool named = a->on != f->manifold;
    int votes = 0, count = named ? pole_named_count(f->named) : f->valueds;
    unsigned random = SGA_SEED_POLE;
    for (int k = 0; k < ASKED; k++) {
        for (int j = 0; j < f->n; j++) {
            random = random * 1103515245u + 12345u;
            a->z[j] = y[j] + BESIDE * a->unit[j] * ((double)(random >> 16 & 0x7fff) / 0x4000 - 1);
        }
        a->z[f->n] = at;
        bool there = find_zero(a) && near_place(a, y, at);
        votes += there && ((!named && (grows(a, 1) || grows(a, -1))) || (count && (has_no_limit(a, 1, count, w) || has_no_limit(a, -1, count, w))));
    }
    return votes;
}

enum field_pole field_pole_at_change(struct field *f, int q, double t, const double *x)
{
    size_t n = (size_t)f->n + 1;
    if (!f->named_asked && f->c && f->n <= SGA_MOST_ROWS_ASKED)
        f->named = pole_named_new(f);
    f->named_asked = true;
    int most = f->named && pole_named_count(f->named) > f->valueds ? pole_named_count(f->named) : f->valueds;
    double *room = sga_calloc((5 + DISTANCES) * n + (DISTANCES + DOUBLINGS) * (size_t)most, sizeof *room), *y = room, *w = room + (5 + DISTANCES) * n;
    struct asked a = { f, f->manifold, q, room + n, room + 2 * n, room + 3 * n, room + 4 * n, { room + 5 * n, room + 6 * n, room + 7 * n }, false };
    double at = field_place_of_change(f, f->pivots + q, f->pole_side[q], t, x, 0.1 * BESIDE, y);
    units(&a, y, at);
    int votes = vote(&a, y, at, w);
    bool far = !a.told && longest(&a, x) > BESIDE;
    if (2 * votes <= ASKED && f->named) {
        a.on = pole_named_rest(f->named);
        a.on->unit = f->manifold->unit;
        votes = vote(&a, y, at, w);
    }
    free(room);
    return 2 * votes > ASKED ? FIELD_POLE : far ? FIELD_POLE_UNKNOWN : FIELD_NO_POLE;
}
