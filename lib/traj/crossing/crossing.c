/* A step of collocation over a place where the constraints' gradients become dependent. */
#include "crossing.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_integration.h>

#include "arena.h"
#include "budget.h"
#include "crossing_place.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "jacobian.h"
#include "manifold.h"
#include "mem.h"
#include "reduction.h"
#include "sizes.h"
#include "system.h"
#include "tape.h"
#include "tolerance.h"
#include "warnings.h"

/* Points of the two steps that are compared; of the motion before; iterations. */
enum { POINTS = 10, FEWER = 8, BEFORE = 10, TURNS = 60, PROJECT = 30 };
/* Half a step's length by the way made, at first, and by which it shrinks; how often. */
static const double FIRST = 0.25, SHRINK = 0.5;
enum { LENGTHS = 12 };
/* Where the motion before is known, in half steps before the place. */
static const double FAR = 3, NEAR = 0.25;
/* The least of the constraints' pivots falls at least so from a whole half step to the point nearest to the place. */
static const double FALLS = 0.5;
/* Iterations have come to an end within this part of the tolerances; what agrees does so within so many of them. */
static const double SETTLED = 1e-3, STILL = 0.3, AGREES = 1;
/* Roundings near the place, by the largest values: tolerances below are not looked for, and what is looked for where they leave no way there. */
static const double FLOOR = 4e-12, PAST = 1e-14, PAST_AGAIN = 1e-12;

/* Nearer to the place than this part of half a step points are not moved onto the constraints, which tell too little of them there. */
static const double MIDDLE = 0.05;

struct scheme { int count; double c[POINTS], a[POINTS][POINTS], b[POINTS]; };

/* The product of (s - c_m)/(c_j - c_m). */
static double lagrange(const struct scheme *s, int j, double at)
{
    double p = 1;
    for (int m = 0; m < s->count; m++)
        if (m != j)
            p *= (at - s->c[m]) / (s->c[j] - s->c[m]);
    return p;
}

/* Gauss' method on [0, 1] (Hairer, Norsett, Wanner, Solving ODE I, II.7). */
static void scheme_make(struct scheme *s, int count)
{
    gsl_integration_glfixed_table *g = gsl_integration_glfixed_table_alloc((size_t)count);
    *s = (struct scheme){ .count = count };
    for (int i = 0; i < count; i++)
        gsl_integration_glfixed_point(0, 1, (size_t)i, s->c + i, s->b + i, g);
    for (int i = 0; i < count; i++)
        for (int m = 0; m < count; m++) {
            double at, weight;
            gsl_integration_glfixed_point(0, s->c[i], (size_t)m, &at, &weight, g);
            for (int j = 0; j < count; j++)
                s->a[i][j] += weight * lagrange(s, j, at);
        }
    double all = 0;
    for (int i = 0; i < count; i++)
        all += s->b[i];
    assert(fabs(all - 1) < 1e-14);       /* of the whole step */
    gsl_integration_glfixed_table_free(g);
}

/* The polynomial through count points (t, x by rows), at a time. */
static void through(int n, int count, const double *t, const double *x, double at, double *y)
{
    memset(y, 0, (size_t)n * sizeof *y);
    for (int i = 0; i < count; i++) {
        double p = 1;
        for (int m = 0; m < count; m++)
            if (m != i)
                p *= (at - t[m]) / (t[i] - t[m]);
        for (int j = 0; j < n; j++)
            y[j] += p * x[(size_t)i * (size_t)n + (size_t)j];
    }
}

struct way {
    struct flow *f;
    const struct traj_request *rq;
    double *scale, *asked, *unit;    /* n: what differs by no more is one; the error allowed; sizes, see take_units */
    double at, half;          /* the place; half a step, with the sign of the motion's direction */
    double before_t[BEFORE], *before;      /* BEFORE x n */
    double *x0;               /* n: the begin of the step */
};

/* The largest difference in units of the error allowed. */
static double apart(const struct way *w, const double *a, const double *b)
{
    double most = 0;
    for (int j = 0; j < w->f->n; j++) {
        double d = fabs(a[j] - b[j]) / w->scale[j];
        most = isnan(d) ? INFINITY : fmax(most, d);
    }
    return most;
}

static bool onto(const struct way *w, double t, double *x)
{
    return manifold_project(w->f->manifold, t, x, w->scale, NULL, PROJECT, NULL, NULL, NULL);
}

/* The field at a point of its own side. */
static bool value(const struct way *w, double t, const double *x, double *v)
{
    struct field *f = w->f->field;
    f->start_t = t;
    f->beyond = -1;
    return field_eval(f, t, x, v) && f->beyond < 0;
}

/* The constraints' gradients at a point, for variables in w->unit, c x n, malloced; NULL: they have no values. */
static double *gradients(const struct way *w, double t, const double *x)
{
    struct field *f = w->f->field;
    size_t n = (size_t)f->n;
    field_load(f, t, x);
    if (!num_jacobian_eval(f->jac, f->in, NULL, f->jac_value))
        return NULL;
    double *a = sga_calloc((size_t)f->c * n + 1, sizeof *a);
    for (int i = 0; i < f->c; i++)
        for (int k = f->jac->start[i]; k < f->jac->start[i + 1]; k++)
            if (f->jac->col[k] < f->n)
                a[(size_t)i * n + (size_t)f->jac->col[k]] = f->jac_value[k] * w->unit[f->jac->col[k]];
    return a;
}

/* Their least pivot, each by its largest entry far from the place (size; set where it is 0). */
static double least_pivot(const struct way *w, double t, const double *x, double *size)
{
    int n = w->f->field->n, c = w->f->field->c;
    SGA_FREED double *a = gradients(w, t, x);
    for (int i = 0; i < c && a; i++) {
        double big = 0;
        for (int j = 0; j < n; j++)
            big = fmax(big, fabs(a[i * n + j]));
        if (!(size[i] > 0))
            size[i] = big > 0 ? big : 1;
        for (int j = 0; j < n; j++)
            a[i * n + j] /= size[i];
    }
    return a ? field_left_for(a, c, n, c) : NAN;
}

/* One step: its points x (count x n) and its end. */
static bool collocate(const struct way *w, const struct scheme *s, double *x, double *end)
{
    int n = w->f->n, turn;
    double h = 2 * w->half, t0 = w->at - w->half, *v = sga_malloc((size_t)(s->count + 1) * (size_t)(n + 1) * sizeof *v), *y = v + (size_t)s->count * (size_t)n, moved = INFINITY, before;
    bool ok = true;
    for (int i = 0; i < s->count && ok; i++) {
        through(n, BEFORE, w->before_t, w->before, t0 + s->c[i] * h, x + (size_t)i * (size_t)n);
        ok = onto(w, t0 + s->c[i] * h, x + (size_t)i * (size_t)n);
    }
    for (turn = 0; turn < TURNS && ok && moved > SETTLED; turn++) {
        before = moved;
        moved = 0;
        for (int i = 0; i < s->count && ok; i++)
            ok = value(w, t0 + s->c[i] * h, x + (size_t)i * (size_t)n, v + (size_t)i * (size_t)n);
        for (int i = 0; i < s->count && ok; i++) {
            for (int j = 0; j < n; j++) {
                y[j] = w->x0[j];
                for (int m = 0; m < s->count; m++)
                    y[j] += h * s->a[i][m] * v[(size_t)m * (size_t)n + (size_t)j];
            }
            ok = onto(w, t0 + s->c[i] * h, y);
            moved = fmax(moved, apart(w, y, x + (size_t)i * (size_t)n));
            memcpy(x + (size_t)i * (size_t)n, y, (size_t)n * sizeof *y);
        }
        ok = ok && isfinite(moved) && !(turn > 8 && moved > 2 * before && moved > STILL);
        if (moved <= STILL && moved > 0.5 * before)
            break;      /* roundings */
    }
    for (int j = 0; j < n && ok; j++) {
        end[j] = w->x0[j];
        for (int m = 0; m < s->count; m++)
            end[j] += h * s->b[m] * v[(size_t)m * (size_t)n + (size_t)j];
    }
    ok = ok && moved <= STILL && onto(w, t0 + h, end) && value(w, t0 + h, end, v);
    free(v);
    return ok;
}

/* How far before the place, in half steps, the motion is known: the step's begin first, then Chebyshev's points. */
static double before_place(int i)
{
    return i == 0 ? 1 : 0.5 * (FAR + NEAR) + 0.5 * (FAR - NEAR) * cos((2 * i - 1) * M_PI / (2.0 * BEFORE));
}

/* The motion before, at the times that all lengths ask for. */
struct past { int count; double t[LENGTHS * (BEFORE + 1)]; struct traj_result r; };

static int further_back(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

static bool past_make(struct past *p, const struct way *w, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq)
{
    struct traj_request q = *rq;
    struct sga_error ignored = { 0 };
    double half = fabs(w->half), side = w->half < 0 ? -1 : 1;
    p->count = 0;
    for (int k = 0; k < LENGTHS; k++, half *= SHRINK)
        for (int i = 0; i <= BEFORE; i++)
            p->t[p->count++] = before_place(i) * half;
    qsort(p->t, (size_t)p->count, sizeof *p->t, further_back);
    for (int i = 0; i < p->count; i++)
        p->t[i] = w->at - side * p->t[i];
    q.times = p->t;
    q.samples = p->count;
    q.outputs = q.events = q.integrals = q.valueds = 0;
    q.beside = NULL;
    q.event_side = NULL;
    q.arithmetic = TRAJ_DOUBLE;
    q.exact_start = EXPR_UNDEF;
    q.exact_initial = q.exact_time = NULL;
    q.single = true;
    q.ends_there = true;
    bool ok = false;
    for (int k = 0; k < 2 && (k == 0 || (p->r.rows < p->count && rq->rtol < PAST_AGAIN)); k++) {
        q.rtol = fmax(rq->rtol, k ? PAST_AGAIN : PAST);         /* of a request in longer numbers */
        q.atol = fmax(rq->atol, k ? PAST_AGAIN : PAST);
        traj_result_clear(&p->r);
        ok = traj_run(sys, sol, &q, &p->r, &ignored);
    }
    return ok;
}

/* What this half step looks at. False: the motion did not come so far. */
static bool look_back(struct way *w, const struct past *p)
{
    size_t n = (size_t)w->f->n;
    if (p->r.columns != (int)n)
        return false;
    for (int i = 0; i <= BEFORE; i++) {
        double t = w->at - before_place(i) * w->half;
        int row = 0;
        while (row < p->r.rows && !(fabs(p->r.t[row] - t) <= 1e-9 * fabs(w->half)))
            row++;
        if (row == p->r.rows)
            return false;
        if (i > 0)
            w->before_t[i - 1] = p->r.t[row];
        memcpy(i > 0 ? w->before + (size_t)(i - 1) * n : w->x0, p->r.value + (size_t)row * n, n * sizeof(double));
    }
    return true;
}

/* Whether events that end the piece happen on the far side of the step: it goes on there. */
static bool stops_on(const struct way *w, const struct crossing *c)
{
    enum { LOOKS = 64 };
    int events = w->rq->events;
    double *g = sga_calloc(2 * (size_t)events + 1, sizeof *g), *first = g + events, *x = sga_malloc(((size_t)c->n + 2) * sizeof *x);
    bool any = false;
    bool stops = false;
    for (int e = 0; e < events; e++)
        stops |= w->rq->event[e].stop;
    for (int k = 0; k <= LOOKS && stops && !any; k++) {
        double t = c->at + (c->to - c->at) * (k - 0.2 * (k == 0) * LOOKS) / LOOKS;
        crossing_at(c, t, x, NULL);
        x[c->n] = t;
        any = !num_tape_eval(w->f->event, x, k ? g : first);
        for (int e = 0; e < events && k; e++)
            any |= w->rq->event[e].stop && !(g[e] * first[e] > 0);
    }
    free(g);
    free(x);
    return any;
}

/* When the curve comes nearest to the place z, from about t on. */
static double nearest(const struct way *w, const struct crossing *c, double t, const double *z)
{
    int n = c->n;
    double *x = sga_malloc(3 * (size_t)(n + 1) * sizeof *x), *a = x + n + 1, *b = a + n + 1, h = 1e-3 * w->half;
    for (int turn = 0; turn < 3; turn++) {
        double up = 0, down = 0;
        through(n, c->count, c->t, c->x, t, x);
        through(n, c->count, c->t, c->x, t + h, a);
        through(n, c->count, c->t, c->x, t - h, b);
        for (int j = 0; j < n; j++) {
            double rate = (a[j] - b[j]) / (2 * h) / w->f->sizes->unit[j];
            up += rate * (z[j] - x[j]) / w->f->sizes->unit[j];
            down += rate * rate;
        }
        if (down > 0 && fabs(up) <= 1e-3 * fabs(w->half) * down)
            t += up / down;
    }
    free(x);
    return t;
}

/* The constraints cross themselves on the curve, to rounding; its time is known from there. Branches that only pass each other closely are another
 * matter: the motion turns with one of them. */
static bool exactly_there(const struct way *w, struct crossing *c)
{
    static const double CLOSE = 1e-3;      /* of the way made in half a step; beside the tolerances */
    int n = c->n;
    double *z = sga_malloc(3 * (size_t)(n + 1) * sizeof *z), *x = z + n + 1, *y = x + n + 1;
    crossing_at(c, w->at, z, NULL);
    z[n] = w->at;
    crossing_at(c, c->from, y, NULL);
    y[n] = c->from;
    bool ok = crossing_place(w->f, w->unit, fabs(w->half), y, z) && fabs(z[n] - w->at) <= MIDDLE * fabs(w->half);
    if (ok) {
        crossing_at(c, z[n], x, NULL);
        for (int j = 0; j < n; j++)
            ok &= fabs(x[j] - z[j]) <= 16 * w->scale[j] + CLOSE * fabs(z[j] - y[j]);
        c->at = ok ? nearest(w, c, z[n], z) : c->at;
    }
    free(z);
    return ok;
}

/* A table changes its polynomial in the step: the curve is not analytic there. */
static bool knot_inside(const struct way *w)
{
    bool any = false;
    for (int i = 0; i < w->f->knots && !any; i++)
        any = fabs(w->f->knot[i] - w->at) <= 1.001 * fabs(w->half);
    return any;
}

/* The step of this length. */
static bool try_step(struct way *w, const struct scheme *fine, const struct scheme *coarse, struct crossing *c)
{
    int n = w->f->n;
    double *other = sga_malloc((size_t)(POINTS + 2) * (size_t)(n + 1) * sizeof *other), *end = other + (size_t)POINTS * (size_t)n, *size = sga_calloc((size_t)w->f->field->c + 1, sizeof *size);
    *c = (struct crossing){ .flow = w->f, .n = n, .count = POINTS + 2 };
    c->at = w->at;
    c->from = w->at - w->half;
    c->to = w->at + w->half;
    c->t = sga_malloc((size_t)c->count * sizeof *c->t);
    c->x = sga_malloc((size_t)c->count * (size_t)(n + 1) * sizeof *c->x);
    c->end = sga_malloc((size_t)(n + 1) * sizeof *c->end);
    bool ok = collocate(w, fine, c->x, c->end) && collocate(w, coarse, other, end);
    ok = ok && apart(w, c->end, end) <= AGREES;
    for (int j = 0; j < n && ok; j++)
        c->error = fmax(c->error, fabs(c->end[j] - end[j]) / w->asked[j]);
    for (int i = 0; i < POINTS; i++)
        c->t[i] = c->from + fine->c[i] * (c->to - c->from);
    c->t[POINTS] = c->from;
    c->t[POINTS + 1] = c->to;
    memcpy(c->x + (size_t)POINTS * (size_t)n, w->x0, (size_t)n * sizeof *c->x);
    memcpy(c->x + (size_t)(POINTS + 1) * (size_t)n, c->end, (size_t)n * sizeof *c->x);
    c->unit = memcpy(sga_malloc((size_t)(n + 1) * sizeof *c->unit), w->unit, (size_t)n * sizeof *c->unit);
    for (int i = 0; i < BEFORE && ok; i++)      /* the same curve as the motion's */
        if (fabs(w->before_t[i] - w->at) < fabs(w->half)) {
            crossing_at(c, w->before_t[i], end, NULL);
            ok = apart(w, end, w->before + (size_t)i * (size_t)n) <= 4 * AGREES;
        }
    for (int i = 0; i < coarse->count && ok; i++) {
        crossing_at(c, c->from + coarse->c[i] * (c->to - c->from), end, NULL);
        ok = apart(w, end, other + (size_t)i * (size_t)n) <= 4 * AGREES;
    }
    if (ok) {
        double far = least_pivot(w, c->from, w->x0, size), near = least_pivot(w, c->t[POINTS / 2 - 1], c->x + (size_t)(POINTS / 2 - 1) * (size_t)n, size);
        double beyond = least_pivot(w, c->t[POINTS / 2], c->x + (size_t)(POINTS / 2) * (size_t)n, size);
        ok = near > 0 && beyond > 0 && near <= FALLS * far && beyond <= FALLS * far;
    }
    ok = ok && exactly_there(w, c) && !stops_on(w, c);
    if (!ok) {
        c->flow = NULL;
        crossing_clear(c);
    }
    free(other);
    free(size);
    return ok;
}

/* Sizes of the variables at the begin of the step that do not depend on the units that they are given in: columns of the constraints' gradients are of one
 * size in them (field_balance), and the way made in half a step is 1 for the variable that moves most (where none of those moves, the largest is 1).
 * A variable that the constraints do not have there has the size of its way. */
static bool take_units(struct way *w)
{
    static const double RESTS = 1e-3;
    int n = w->f->n;
    double way = 0, place = 0, t = w->at - w->half;
    for (int j = 0; j < n; j++)
        w->unit[j] = 1;
    SGA_FREED double *v = sga_malloc(2 * ((size_t)n + 1) * sizeof *v);
    double *column = v + n + 1;
    SGA_FREED double *a = value(w, t, w->x0, v) ? gradients(w, t, w->x0) : NULL;
    if (!a)
        return false;
    field_balance(a, w->f->field->c, n, column);
    for (int j = 0; j < n; j++) {
        way = column[j] > 0 ? fmax(way, fabs(v[j] * w->half) / column[j]) : way;
        place = column[j] > 0 ? fmax(place, fabs(w->x0[j]) / column[j]) : place;
    }
    way = way > RESTS * place ? way : place;
    bool ok = true;
    for (int j = 0; j < n && ok; j++) {
        w->unit[j] = column[j] > 0 && way > 0 ? column[j] * way : fmax(w->f->sizes->unit[j], fabs(v[j] * w->half));
        ok = w->unit[j] > 0 && isfinite(w->unit[j]);
    }
    return ok;
}

/* What differs by less is one at this point of the search: the tolerances, by what the variables were before. */
static void take_scale(struct way *w)
{
    for (int j = 0; j < w->f->n; j++) {
        double most = 0;
        for (int i = 0; i < BEFORE; i++)
            most = fmax(most, fabs(w->before[i * w->f->n + j]));
        w->asked[j] = sga_allowed((struct sga_tolerance){ w->rq->rtol, w->rq->atol }, w->f->sizes->unit[j], most);
        w->scale[j] = fmax(w->asked[j], FLOOR * fmax(w->unit[j], fmax(most, w->f->sizes->unit[j])));
    }
}

bool crossing_find(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double at, struct crossing *c)
{
    struct sga_error ignored = { 0 };
    size_t n = (size_t)sys->variables;
    double stop = rq->times[rq->samples - 1];
    *c = (struct crossing){ 0 };
    if (!sol->constraints || n > SGA_MOST_ROWS_ASKED || stop == at || at == rq->start)
        return false;
    struct way w = { .f = sga_calloc(1, sizeof *w.f), .rq = rq, .at = at, .half = FIRST * (at - rq->start) };
    if (fabs(w.half) > fabs(stop - at))
        w.half = stop - at;
    w.scale = sga_malloc(3 * (n + 1) * sizeof *w.scale);
    w.asked = w.scale + n + 1;
    w.unit = w.asked + n + 1;
    w.before = sga_malloc((BEFORE + 2) * (n + 1) * sizeof *w.before);
    w.x0 = w.before + (size_t)BEFORE * n;
    struct past past = { 0 };
    struct scheme fine, coarse;
    bool ok = flow_init(w.f, sys, sol, rq, &ignored) && past_make(&past, &w, sys, sol, rq), found = false;
    scheme_make(&fine, POINTS);
    scheme_make(&coarse, FEWER);
    for (int k = 0; k < LENGTHS && ok && !found && sga_budget_ok(rq->budget, &ignored); k++, w.half *= SHRINK) {
        if (knot_inside(&w) || !look_back(&w, &past))
            continue;
        ok = w.f->field->rank >= 0 || field_begin(w.f->field, w.at - w.half, w.x0, &ignored);
        if (!ok || !take_units(&w))
            continue;
        take_scale(&w);
        found = try_step(&w, &fine, &coarse, c);
    }
    traj_result_clear(&past.r);
    assert(!found || ((c->at - c->from) * (c->to - c->at) > 0 && c->error >= 0));       /* the place lies inside the step */
    if (!found) {
        flow_clear(w.f);
        free(w.f);
    }
    free(w.scale);
    free(w.before);
    return found;
}

void crossing_at(const struct crossing *c, double t, double *x, double *y)
{
    assert(fabs(t - c->from) <= 1.001 * fabs(c->to - c->from) && fabs(t - c->to) <= 1.001 * fabs(c->to - c->from));      /* inside, but for roundings */
    through(c->n, c->count, c->t, c->x, t, x);
    if (fabs(t - c->at) > MIDDLE * fabs(c->to - c->at)) {
        double *z = memcpy(sga_malloc((size_t)(c->n + 1) * sizeof *z), x, (size_t)c->n * sizeof *z);
        if (manifold_project(c->flow->manifold, t, z, NULL, NULL, PROJECT, NULL, NULL, NULL))
            memcpy(x, z, (size_t)c->n * sizeof *z);
        free(z);
    }
    if (y)
        flow_output(c->flow, t, x, y);
}

void crossing_clear(struct crossing *c)
{
    if (c->flow)
        flow_clear(c->flow);
    free(c->flow);
    free(c->t);
    free(c->x);
    free(c->end);
    free(c->unit);
    *c = (struct crossing){ 0 };
}
