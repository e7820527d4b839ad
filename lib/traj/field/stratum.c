/* A solution that seems to grow without bound may only have come to a stratum: what is solved for there (a multiplier, a
 * derivative) tends to infinity, while the variables on which a pivot depends stay finite and the pivot tends
 * to 0 at the same time. Then it is the equations' rank that ends the motion. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "derive.h"
#include "error.h"
#include "facts.h"
#include "field.h"
#include "mem.h"
#include "signal.h"
#include "system.h"
#include "tape.h"

/* Variables this much larger than where the motion started are on their way to infinity. */
static const double GROWN = 1e3;
/* The pivot is nearly 0, and going on as it does it reaches 0 within this part of the time passed. The first pair is for
 * motions that stop short of the stratum, because what grows leaves no digits for steps; the second for roots, of the fifth degree at the most. (Beside a
 * stiff end velocities are roundings, and any pivot seems to fall.) */
static const struct { double shrunk, soon; } near_zero[] = { { 1e-4, 1e-3 }, { 0.1, 1e-5 } };

/* Zeros of higher order fall early, and are told by where they are. */
static const double SMALL_THERE = 1e-2, LARGE_THERE = 10, AS_POLE = 0.3;

/* By a line and by a parabola, of the way there. */
static const double ALIKE = 0.05;

/* p depends on no variable that grows. */
static bool stays_finite(const struct field *f, expr_id p, const unsigned char *grown)
{
    struct expr_cone cone;
    bool ok = true;
    expr_cone_init(&cone);
    expr_cone_of(f->sys->store, &cone, &p, 1);
    for (int i = 0; i < cone.count && ok; i++) {
        const struct expr_node *n = f->sys->store->node + cone.list[i];
        ok = n->op != EXPR_SYM || !grown[n->a];
    }
    expr_cone_clear(&cone);
    return ok;
}

/* p and its derivative along v, at (t, x). */
static bool along(const struct field *f, expr_id p, double t, const double *x, const double *v, double out[2])
{
    struct expr_store *st = f->sys->store;
    int n = f->n, *inputs = sga_malloc((size_t)(n + 1) * sizeof *inputs);
    expr_id *root = sga_malloc((size_t)(n + 2) * sizeof *root);
    double *in = sga_malloc((size_t)(n + 1) * sizeof *in), *value = sga_malloc((size_t)(n + 2) * sizeof *value);
    root[0] = p;
    for (int j = 0; j <= n; j++) {
        inputs[j] = j < n ? f->sys->variable[j].symbol : f->sys->time;
        in[j] = j < n ? x[j] : t;
        root[j + 1] = j < n ? expr_diff(st, p, inputs[j]) : expr_time_partial(st, p, inputs[j]);
    }
    struct sga_error ignored = { 0 };
    struct num_tape *tape = expr_store_ok(st) ? num_tape_new(st, root, n + 2, inputs, n + 1, &ignored) : NULL;
    bool ok = tape && num_tape_eval(tape, in, value);
    out[0] = value[0];
    out[1] = ok ? value[n + 1] : 0;
    for (int j = 0; j < n && ok; j++)
        out[1] += value[j + 1] != 0 ? value[j + 1] * v[j] : 0;
    num_tape_free(tape);
    free(inputs);
    free(root);
    free(in);
    free(value);
    return ok && isfinite(out[1]);
}

/* The field as its expressions have it, whatever its pivots are. */
static bool plain(struct field *f, double t, const double *x, double *v)
{
    field_load(f, t, x);
    bool ok = f->fast && num_tape_eval(f->direct, f->in, f->direct_out);
    for (int j = 0; j < f->n && ok; j++) {
        v[j] = f->direct_out[j];
        ok = isfinite(v[j]);
    }
    return ok;
}

/* One step of the classical method of order four. */
static bool runge(struct field *f, double t, double h, double *x)
{
    size_t n = (size_t)f->n;
    double *k = sga_malloc(6 * (n + 1) * sizeof *k), *y = k + 4 * (n + 1);
    bool ok = true;
    for (int s = 0; s < 4 && ok; s++) {
        double part = s == 0 ? 0 : s == 3 ? 1 : 0.5;
        for (size_t j = 0; j < n; j++)
            y[j] = x[j] + (s ? part * h * k[(size_t)(s - 1) * (n + 1) + j] : 0);
        ok = plain(f, t + part * h, y, k + (size_t)s * (n + 1));
    }
    for (size_t j = 0; j < n && ok; j++)
        x[j] += h / 6 * (k[j] + 2 * k[n + 1 + j] + 2 * k[2 * (n + 1) + j] + k[3 * (n + 1) + j]);
    free(k);
    return ok;
}

/* p/p' is 0 where p is, of whatever order, and has a slope there: by a parabola through three of its values on the way made, the last of them at the last
 * point inside. What grows has no part in p, nor, as far as the field is smooth in the others, in these. */
double field_zero_ahead(struct field *f, int pivot)
{
    enum { PLACES = 3, FINE = 8 };         /* what grows as a pole falls by half on the first of these ways: steps are as many times shorter */
    static const double back[PLACES] = { 0, 1, 3 };
    size_t n = (size_t)f->n;
    double *x = sga_malloc(2 * (n + 1) * sizeof *x), *v = x + n + 1, t[PLACES], u[PLACES], p[2], gap = 0;
    bool ok = true;
    assert(pivot >= 0 && pivot < f->pivots);
    for (int k = 0; k < PLACES && ok; k++) {
        for (size_t j = 0; j < n; j++)
            x[j] = f->here[j];
        for (int s = 0; s < FINE * (int)back[k] && ok; s++)
            ok = runge(f, f->here_t - s * gap / FINE, -gap / FINE, x);
        t[k] = -back[k] * gap;
        ok = ok && plain(f, f->here_t + t[k], x, v) && along(f, f->pivot_expr[pivot], f->here_t + t[k], x, v, p) && p[1] != 0;
        u[k] = ok ? p[0] / p[1] : 0;
        if (k == 0)
            gap = -u[0];
        ok = ok && gap != 0;
    }
    free(x);
    if (!ok)
        return NAN;
    /* t as a polynomial of u, at u = 0 */
    double at = 0;
    for (int k = 0; k < PLACES; k++) {
        double part = t[k];
        for (int m = 0; m < PLACES; m++)
            part *= m == k ? 1 : u[m] / (u[m] - u[k]);
        at += part;
    }
    double line = t[0] - u[0] * (t[1] - t[0]) / (u[1] - u[0]);
    return fabs(at - line) <= ALIKE * fabs(at) ? f->here_t + at : NAN;     /* else it is no zero that these see */
}

/* Variable j is large, and grows as what has a pole at the end of this way does (a turn back has a derivative without bound, too). */
static bool rises(const struct field *f, const double *start, const double *v, double way, int j)
{
    return fabs(f->here[j]) > LARGE_THERE * (1 + fabs(start[j])) && fabs(v[j] * way) > AS_POLE * fabs(f->here[j]);
}

static bool any_rises(const struct field *f, const double *start, const double *v, double way)
{
    bool any = false;
    for (int j = 0; j < f->n && !any; j++)
        any = rises(f, start, v, way, j);
    return any;
}

int field_grows_with(struct field *f, int pivot, const double *start)
{
    const size_t n = (size_t)f->n;
    double *x = sga_malloc(2 * (n + 1) * sizeof *x), *v = x + n + 1, p[2], most = 0;
    unsigned char *grows = sga_calloc((size_t)f->sys->store->symbols + 1, 1);
    int which = -1;
    assert(pivot >= 0 && pivot < f->pivots);
    sga_copy(x, f->here, f->n);
    bool known = plain(f, f->here_t, x, v) && along(f, f->pivot_expr[pivot], f->here_t, x, v, p) && p[1] != 0;
    double way = known ? -p[0] / p[1] : 0;
    for (int j = 0; j < f->n && way * (f->here_t - f->start_t) > 0; j++) {
        double by = fabs(x[j]) / (1 + fabs(start[j]));
        if (!rises(f, start, v, way, j))
            continue;
        grows[f->sys->variable[j].symbol] = 1;
        which = by > most ? j : which;
        most = fmax(most, by);
    }
    if (which >= 0 && stays_finite(f, f->pivot_expr[pivot], grows))
        which = -1;
    free(x);
    free(grows);
    return which;
}

/* What is never 0 tends to 0 only as something grows without bound. */
static bool may_vanish(const struct field *f, expr_id p)
{
    struct expr_facts facts;
    expr_facts_init(&facts);
    bool may = !(expr_facts_of(&facts, f->sys->store, p) & EXPR_NONZERO);
    expr_facts_clear(&facts);
    return may;
}

/* Where a motion ends: the velocity there, what has grown, how much time has passed. */
struct end {
    double *x, *v;
    unsigned char *grown;      /* by symbol */
    double passed;
};

static void end_of(struct field *f, const double *start, double passed, struct end *end)
{
    end->passed = passed;
    end->grown = sga_calloc((size_t)f->sys->store->symbols + 1, 1);
    end->v = sga_calloc(2 * ((size_t)f->n + 1), sizeof *end->v);
    end->x = end->v + f->n + 1;
    for (int j = 0; j < f->n; j++) {
        end->x[j] = f->here[j];
        end->grown[f->sys->variable[j].symbol] = fabs(f->here[j]) > GROWN * (1 + fabs(start[j]));
    }
}

static void end_clear(struct end *end)
{
    free(end->v);
    free(end->grown);
}

/* After which part of the way made p, which was `was` at the start, comes to 0 along a line, negative where it grows; NAN: it grows with what does so,
 * or is 0 nowhere. *near: that is soon. */
static double left_to_zero(struct field *f, expr_id e, double was, const struct end *end, double *value, bool *near)
{
    double p[2];
    *near = false;
    if (!stays_finite(f, e, end->grown) || !may_vanish(f, e) || !along(f, e, f->here_t, end->x, end->v, p) || p[1] == 0)
        return NAN;
    double left = -p[0] / p[1] / end->passed;
    *value = fabs(p[0]);
    *near = p[0] == 0;
    for (int k = 0; k < 2 && left > 0; k++)
        *near |= left < near_zero[k].soon && *value <= near_zero[k].shrunk * was;
    return left;
}

/* The denominator that comes to 0 soonest, and when; -1: none. */
static int pole_ahead(struct field *f, const double *start, double start_t, const struct end *end, double *soonest)
{
    int found = -1;
    *soonest = INFINITY;
    for (int q = 0; q < f->poles; q++) {
        double was[2], value;
        bool near;
        if (!along(f, f->pole_expr[q], start_t, start, end->v, was))
            continue;
        double left = left_to_zero(f, f->pole_expr[q], fabs(was[0]), end, &value, &near);
        if (near && left < *soonest) {
            *soonest = left;
            found = q;
        }
    }
    return found;
}

/* A pivot that comes to 0 later than this beside a pole only moves fast there, as all does. */
static const double POLE_FIRST = 0.5;

int field_approaches(struct field *f, const double *start, double start_t, double end_t, double apart, bool choice, int *pole)
{
    int found = -1;
    struct end end;
    end_of(f, start, end_t - start_t, &end);
    bool moves = plain(f, f->here_t, end.x, end.v) || field_eval(f, f->here_t, end.x, end.v);      /* beside a zero the expressions say more than the rows */
    double soonest = INFINITY, of_pole = INFINITY;      /* where one of them falls fast, so do others that depend on the same */
    int before = moves ? pole_ahead(f, start, start_t, &end, &of_pole) : -1;
    for (int q = choice ? f->chosen : 0; q < (choice ? f->pivots : f->chosen) && moves; q++) {
        double value;
        bool near;
        double left = left_to_zero(f, f->pivot_expr[q], f->pivot_start[q], &end, &value, &near);
        if (!near && left > 0 && value <= SMALL_THERE * f->pivot_start[q]) {
            double zero = field_zero_ahead(f, q);
            near = fabs(zero - end_t) <= apart * fabs(end.passed) && any_rises(f, start, end.v, zero - f->here_t);
        }
        if (near && left < soonest && !(of_pole < POLE_FIRST * left)) {
            soonest = left;
            found = q;
        }
    }
    if (pole)
        *pole = found < 0 ? before : -1;
    end_clear(&end);
    return found;
}
