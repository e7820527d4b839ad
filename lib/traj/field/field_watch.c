/* What is watched along a motion: pivots of the reduction and denominators of the equations, by the sides of
 * their zeros on which the motion is. */
#include "field.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "facts.h"
#include "manifold.h"
#include "mem.h"
#include "points_space.h"
#include "poly.h"
#include "system.h"
#include "tape.h"
#include "watch.h"

/* A pivot this much smaller than at the start hands over to the general way. */
static const double PIVOT_SHRUNK = 1e-5;

/* What |value| of a pivot must exceed for the expressions to be used. Nothing is divided by the function of a side. */
static double least(const struct field *f, int q)
{
    return q < f->sides ? 0 : PIVOT_SHRUNK * f->pivot_start[q];
}

void field_list_add(struct field_list *l, expr_id e)
{
    SGA_RESERVE(l->e, l->cap, l->count + 1);
    l->e[l->count++] = e;
}

/* What is watched for zeros: the factors of each pivot, because x^2 touches 0 where x
 * passes it; the pivot itself where it is too large to factor. */
void field_watch_pivot(struct field *f, expr_id pivot, struct field_list *l)
{
    struct poly_limits limits = poly_limits_of(POLY_GLANCE, NULL);
    struct poly_factors q;
    bool origin;
    if ((poly_shown_irreducible(f->sys->store, pivot, &origin) && origin) || !poly_numerator_factors(f->sys->store, pivot, &limits, &q)) {
        field_list_add(l, pivot);
        return;
    }
    for (int i = 0; i < q.factors; i++)
        if (!q.factor[i].never_zero && q.factor[i].depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME))
            field_list_add(l, q.factor[i].expr);
    poly_factors_clear(&q);
}

void field_take_sides(struct field *f, double t, const double *x)
{
    memcpy(f->here, x, (size_t)f->n * sizeof *x);
    f->here_t = f->start_t = t;
    f->lost_pivot = f->beyond = -1;
    f->over = false;
    field_along_anew(f);
    for (int q = 0; q < f->pivots; q++) {
        double p = f->direct_out[f->n + q];
        f->pivot_side[q] = p > 0 ? 1 : p < 0 ? -1 : 0;
    }
    for (int q = 0; q < f->sides; q++)
        if (f->solution_side[q].unseen && f->pivot_side[q] != f->solution_side[q].sign)
            f->beyond = q;
    f->lost_pole = -1;
    memcpy(f->pole_from, x, (size_t)f->n * sizeof *x);
    for (int q = 0; q < f->poles; q++) {
        double p = f->direct_out[f->n + f->pivots + q];
        f->pole_side[q] = p > 0 ? 1 : p < 0 ? -1 : 0;
    }
    field_keep_sides(f, t, x);
}

void field_keep_sides(struct field *f, double t, const double *x)
{
    sga_copy(f->home, x, f->n);
    sga_copy(f->home + f->n, f->pivot_side, f->pivots);
    sga_copy(f->home + f->n + f->pivots, f->pole_side, f->poles);
    f->home_t = t;
}

void field_forget_trial(struct field *f)
{
    f->over = false;
    sga_copy(f->here, f->home, f->n);
    sga_copy(f->pivot_side, f->home + f->n, f->pivots);
    sga_copy(f->pole_side, f->home + f->n + f->pivots, f->poles);
    f->here_t = f->home_t;
}

/* The root at the part s of the way from the last good point to (t, x). */
static double root_between(struct field *f, int k, double s, double t, const double *x, double *y, double *at)
{
    for (int j = 0; j < f->n; j++)
        y[j] = f->here[j] + s * (x[j] - f->here[j]);
    *at = f->here_t + s * (t - f->here_t);
    if (f->manifold->c)
        manifold_project(f->manifold, *at, y, NULL, NULL, 8, NULL, NULL, NULL);
    field_load(f, *at, y);
    num_tape_eval(f->direct, f->in, f->direct_out);
    return f->direct_out[f->n + k];
}

/* Each turn is a projection: regula falsi (Illinois), and a bisection in every third turn, for roots that bend. */
double field_place_of_change(struct field *f, int k, double side, double t, const double *x, double near, double *y)
{
    double low = 0, high = 1, at = 0, above = side * root_between(f, k, 0, t, x, y, &at);
    double below = side * root_between(f, k, 1, t, x, y, &at);
    int last = 0;
    assert(k >= 0 && k < f->pivots + f->poles);
    for (int turn = 0; turn < 120 && high - low > near && (turn < 2 || sga_watch_ok()); turn++) {
        double s = high - (high - low) * (-below / (above - below));
        if (turn % 3 == 2 || !(s > low && s < high))
            s = 0.5 * (low + high);
        double p = side * root_between(f, k, s, t, x, y, &at);
        if (p == 0 || s == low || s == high)
            break;
        if (p > 0) {
            low = s;
            above = p;
            below *= last > 0 ? 0.5 : 1;
        } else {
            high = s;
            below = p;
            above *= last < 0 ? 0.5 : 1;
        }
        last = p > 0 ? 1 : -1;
    }
    return at;
}

/* The way to where the rank falls is short beside the way made, and the pivot nearly used up. Nearer still, where the set crosses
 * itself, roundings of the constraints are as large as what tells its branches apart, and steps follow any of them. */
static const double END_NEAR = 1e-5, END_SMALL = 1e-4;

/* A trial may be far from the motion: along its tangent the place is known to the square of the way there, unless the set turns back before. */
void field_fall_refine(struct field *f)
{
    int n = f->n, q = f->fell;
    assert(q >= f->sides && q < f->chosen);       /* a pivot of the reduction */
    double way = f->fell_t - f->home_t, *y = sga_malloc(2 * (size_t)(n + 1) * sizeof *y), *ahead = y + n + 1;
    if (way * (f->home_t - f->start_t) <= 0) {     /* a trial of long ago saw it where the motion has been since */
        way = END_NEAR * (f->home_t - f->start_t);
        f->fell_t = f->home_t;
    }
    field_load(f, f->home_t, f->home);
    if (f->fast && num_tape_eval(f->direct, f->in, f->direct_out)) {
        for (int j = 0; j < n; j++)
            ahead[j] = f->home[j] + 2 * way * f->direct_out[j];
        sga_copy(f->here, f->home, n);
        f->here_t = f->home_t;
        field_load(f, f->home_t + 2 * way, ahead);
        if (num_tape_eval(f->direct, f->in, f->direct_out) && f->direct_out[n + q] * f->home[n + q] < 0)
            f->fell_t = field_place_of_change(f, q, f->home[n + q], f->home_t + 2 * way, ahead, DBL_EPSILON, y);
    }
    free(y);
}

/* Pivot q changed its sign before (t, x), and the rank falls with it: is the place near? */
static bool fall_is_near(struct field *f, int q, double t, const double *x)
{
    double made = fabs(f->home_t - f->start_t);
    if (f->fell != q || !(fabs(t - f->home_t) <= 1000 * END_NEAR * made))
        return false;
    double *y = sga_malloc((size_t)(f->n + 1) * sizeof *y);
    f->fell_t = field_place_of_change(f, q, f->pivot_side[q], t, x, DBL_EPSILON, y);
    free(y);
    field_fall_refine(f);
    field_load(f, f->home_t, f->home);
    num_tape_eval(f->direct, f->in, f->direct_out);
    double way = (f->fell_t - f->home_t) * (f->home_t < f->start_t ? -1 : 1);
    return way > 0 && way <= END_NEAR * made && fabs(f->direct_out[f->n + q]) <= END_SMALL * f->pivot_start[q];
}

/* Pivot q, with which the rank falls at fell_t, is p, as small as where expressions are not used: the motion is there, if that time is as near. Nearer still
 * roundings choose a branch, one on which the pivot keeps its sign perhaps. */
static bool has_fallen(struct field *f, int q, double p)
{
    double made = fabs(f->home_t - f->start_t), way = (f->fell_t - f->home_t) * (f->home_t < f->start_t ? -1 : 1);
    if (f->fell != q || fabs(p) > least(f, q) || !(fabs(way) <= END_NEAR * made))
        return false;
    if (way <= 0)
        f->fell_t = f->home_t;
    return true;
}

/* Between the last good point and x a pivot changed sign: find where, and ask the rank
 * there. True: the rank holds, the pivot only happened to vanish. */
static bool rank_at_change(struct field *f, double t, const double *x, int pivot)
{
    int n = f->n, rank = 0;
    double *y = sga_malloc((size_t)(n + 1) * sizeof *y), *v = sga_malloc((size_t)(n + 1) * sizeof *v);
    double place = field_place_of_change(f, pivot, f->pivot_side[pivot], t, x, DBL_EPSILON, y);
    bool holds = field_general(f, v, &rank) && rank >= f->rank && (f->whole || field_rank_since(f, f->home_t, f->home) >= f->rank);
    free(y);
    free(v);
    if (field_rank_falls(f, pivot, t, x)) {
        f->fell = pivot;
        f->fell_t = place;
        holds = false;
    }
    field_load(f, t, x);
    return holds;
}

bool field_follows(struct field *f, double t, const double *x)
{
    static const double MISS = 1e-6;
    int row;
    if (f->beyond < 0)
        return true;
    field_load(f, t, x);
    bool finite = num_tape_eval(f->direct, f->in, f->direct_out), well = finite && f->fast;
    well = well && field_rows_miss(f, f->direct_out, &row) <= MISS * field_size(f, f->direct_out);
    if (!well) {
        f->lost_pivot = f->beyond;
        f->rank_lost = true;
    }
    return well;
}

/* Side q, beyond which no point was known, is passed on the way to (t, x): what holds at the point of the constraints there? */
static bool passes_unseen(struct field *f, int q, double t, const double *x)
{
    if (!f->solution_side[q].unseen || !f->manifold->c)
        return false;
    double *y = memcpy(sga_malloc(((size_t)f->n + 1) * sizeof *y), x, (size_t)f->n * sizeof *y);
    int before = f->beyond, lost = f->lost_pivot;
    f->beyond = q;
    bool ok = manifold_project(f->manifold, t, y, NULL, NULL, 8, NULL, NULL, NULL) && field_follows(f, t, y);
    if (!ok)
        f->beyond = before;
    f->lost_pivot = ok ? lost : q;
    f->rank_lost = false;
    free(y);
    field_load(f, t, x);
    num_tape_eval(f->direct, f->in, f->direct_out);
    return ok;
}

bool field_inside(struct field *f, double t, const double *x)
{
    for (int q = 0; q < f->pivots; q++) {
        double p = f->direct_out[f->n + q];
        if (q < f->chosen && has_fallen(f, q, p)) {
            f->lost_pivot = q;
            f->over = true;
            return false;
        }
        if (!(p * f->pivot_side[q] < 0))
            continue;
        if (q < f->sides && passes_unseen(f, q, t, x)) {
            f->pivot_side[q] = -f->pivot_side[q];
            continue;
        }
        if (q < f->chosen && (q < f->sides || f->lost_pivot == q || !rank_at_change(f, t, x, q))) {
            f->lost_pivot = q;
            f->over = fall_is_near(f, q, t, x);
            return false;
        }
        f->pivot_side[q] = -f->pivot_side[q];
        num_tape_eval(f->direct, f->in, f->direct_out);
    }
    for (int q = 0; q < f->poles; q++) {
        double p = f->direct_out[f->n + f->pivots + q];
        if (f->pole_side[q] == 0)
            f->pole_side[q] = p > 0 ? 1 : p < 0 ? -1 : 0;
        if (!(p * f->pole_side[q] < 0))
            continue;
        enum field_pole pole = f->lost_pole == q ? FIELD_POLE : field_pole_at_change(f, q, t, x);
        f->lost_pole = pole == FIELD_POLE ? q : f->lost_pole;
        if (pole)
            return false;
        f->pole_side[q] = -f->pole_side[q];
        field_load(f, t, x);
        num_tape_eval(f->direct, f->in, f->direct_out);
    }
    sga_copy(f->here, x, f->n);
    f->here_t = t;
    return true;
}

bool field_pivots_well(const struct field *f)
{
    for (int q = 0; q < f->pivots; q++)
        if (!(fabs(f->direct_out[f->n + q]) > least(f, q)))
            return false;
    return true;
}

bool field_well_inside(const struct field *f, const double *p)
{
    bool ok = f->fast;
    for (int q = 0; q < f->pivots; q++)
        ok &= p[q] * f->pivot_side[q] > least(f, q);
    for (int q = 0; q < f->poles; q++)
        ok &= p[f->pivots + q] * f->pole_side[q] > 0;
    return ok;
}
