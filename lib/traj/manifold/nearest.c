/* Newton's method for the nearest point: see nearest.h. */
#include "nearest.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "leastnorm.h"
#include "lin_symmetric.h"
#include "mem.h"
#include "watch.h"

enum { STEPS = 60, HALVES = 12, SETTLE = 20 };
/* Differences of first derivatives, in units. */
static const double NUDGE = 1e-5;
/* What is left of the gradient at an end: of the whole, and in units (rounding of the set). */
static const double LEVEL = 1e-6, TINY = 1e-9;
/* Tangent vectors with less than this in what counts do not move it. */
static const double FAINT = 1e-11;
/* Second derivatives below this are differences of nothing, beside the 1 that a variable's own distance has. */
static const double FLAT = 1e-6;
/* Rounding of them. */
static const double NOISE = 1e-10;
/* A step so short is Newton's own, and the sum cannot tell any more whether it is lower. */
static const double SHORT = 1e-6;
/* How far to leave a saddle; and how steep the descent from one is at the least. */
static const double AWAY = 0.3;
static const double ROUNDING = 1e-15;
/* Operations of the eigenvectors, times the cube. */
static const double EIGEN = 100;

/* The model of the sum on the tangent space at x. */
struct model {
    int dim;
    double *gradient;            /* dim */
    double *value, *vector;      /* of the second derivative: dim, dim x dim */
    double *second, *full, *bent, *other, *lambda, *big;     /* bent: by tangent vector, the derivative of the gradient along it (n) */
    double steep, size;          /* of the gradient along the set, and before it was projected */
};

static double part(const struct nearest *q, const double *x, int j)
{
    return (x[j] - q->guess[j]) / q->t->unit[j];
}

double nearest_sum(const struct nearest *q, const double *x)
{
    double sum = 0;
    for (int j = 0; j < q->t->n; j++)
        sum += q->weight[j] > 0 ? q->weight[j] * part(q, x, j) * part(q, x, j) : 0;
    return sum;
}

static void model_init(struct model *w, const struct tangent *t)
{
    size_t n = (size_t)t->n, c = (size_t)t->c;
    *w = (struct model){ .gradient = sga_malloc((5 * n + 2 * c + 3 * n * n + 1) * sizeof(double)) };
    w->value = w->gradient + n;
    w->full = w->value + n;
    w->other = w->full + n;
    w->lambda = w->other + 2 * n;
    w->big = w->lambda + c;
    w->vector = w->big + c;
    w->second = w->vector + n * n;
    w->bent = w->second + n * n;
}

static double dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += a[j] * b[j];
    return sum;
}

/* The derivative of J^T lambda along the k-th tangent vector into d; false: it has no value on either side. */
static bool bend(const struct nearest *q, struct model *w, const double *x, int k, double *d)
{
    struct tangent *t = q->t;
    int n = t->n;
    const double *b = t->basis + (size_t)k * (size_t)n;
    double *at = w->other + n;
    bool ok[2];
    for (int s = 0; s < 2; s++) {
        for (int j = 0; j < n; j++)
            at[j] = x[j] + (s ? -NUDGE : NUDGE) * b[j] * t->unit[j];
        ok[s] = tangent_gradient(t, q->time, at, w->lambda, w->big, s ? w->other : d);
    }
    if (!ok[0] && !ok[1])
        return false;
    if (!ok[0] || !ok[1])
        tangent_gradient(t, q->time, x, w->lambda, w->big, ok[0] ? w->other : d);
    for (int j = 0; j < n; j++)
        d[j] = (d[j] - w->other[j]) / (ok[0] && ok[1] ? 2 * NUDGE : NUDGE);
    return true;
}

/* At x; gradient: of the sum's half before it is projected, by all variables. False: no value. */
static bool look(const struct nearest *q, struct model *w, const double *x, const double *gradient, bool curved)
{
    struct tangent *t = q->t;
    int n = t->n;
    if (tangent_at(t, q->time, x) < 0)
        return false;
    tangent_basis(t);
    w->dim = t->dim;
    assert(w->dim >= 0 && w->dim <= n);
    w->steep = 0;
    w->size = sqrt(dot(gradient, gradient, n));
    for (int k = 0; k < w->dim; k++) {
        w->gradient[k] = dot(t->basis + (size_t)k * (size_t)n, gradient, n);
        w->steep += w->gradient[k] * w->gradient[k];
    }
    w->steep = sqrt(w->steep);
    tangent_multipliers(t, gradient, w->lambda);
    sga_copy(w->big, t->m->big, t->c);
    for (int k = 0; k < w->dim && curved; k++) {
        double *bent = w->bent + (size_t)k * (size_t)n;
        if (!bend(q, w, x, k, bent))
            return false;
        for (int j = 0; j < n; j++)
            bent[j] += q->weight[j] * t->basis[(size_t)k * (size_t)n + (size_t)j];
        for (int i = 0; i < w->dim; i++)
            w->second[k * w->dim + i] = dot(t->basis + (size_t)i * (size_t)n, bent, n);
    }
    for (int k = 0; k < w->dim && curved; k++)
        for (int i = 0; i < k; i++)
            w->second[k * w->dim + i] = w->second[i * w->dim + k] = (w->second[k * w->dim + i] + w->second[i * w->dim + k]) / 2;
    t->effort += curved ? EIGEN * w->dim * w->dim * w->dim : 0;
    if (curved)
        lin_symmetric(w->dim, w->second, w->value, w->vector);
    return true;
}

/* Along the set by coefficients of the eigenvectors. */
static void along(const struct nearest *q, const struct model *w, int k, double factor, double *p)
{
    const struct tangent *t = q->t;
    for (int i = 0; i < w->dim; i++)
        for (int j = 0; j < t->n; j++)
            p[j] += factor * w->vector[k * w->dim + i] * t->basis[(size_t)i * (size_t)t->n + (size_t)j];
}

/* Whether the sum bends along the k-th eigenvector: where this moves what counts by little beside what is free of charge (a force that has
 * a name, of a stiff spring), it bends by as little. */
static bool bends(const struct nearest *q, const struct model *w, int k, double *p)
{
    double counts = 0;
    memset(p, 0, (size_t)q->t->n * sizeof *p);
    along(q, w, k, 1, p);
    for (int j = 0; j < q->t->n; j++)
        counts += q->weight[j] * p[j] * p[j];
    return fabs(w->value[k]) > fmax(NOISE, FLAT * fmin(1, counts));
}

/* Newton's step, downwards where the sum bends down too; directions in which it is flat are left alone. */
static void newton(const struct nearest *q, const struct model *w, double *p)
{
    double *v = sga_malloc(((size_t)q->t->n + 1) * sizeof *v);
    memset(p, 0, (size_t)q->t->n * sizeof *p);
    for (int k = 0; k < w->dim; k++) {
        double g = dot(w->vector + (size_t)k * (size_t)w->dim, w->gradient, w->dim);
        if (bends(q, w, k, v))
            along(q, w, k, -g / fabs(w->value[k]), p);
        else if (fabs(g) > FLAT * w->size)
            along(q, w, k, -g, p);
    }
    free(v);
}

/* Of both ways along p the one on which the first variable by name grows. */
static void turn_upwards(const struct nearest *q, double *p)
{
    int i = 0, n = q->t->n;
    while (i < n && fabs(p[q->by_name[i]]) < FLAT)
        i++;
    double sign = i < n && p[q->by_name[i]] < 0 ? -1 : 1;
    for (int j = 0; j < n; j++)
        p[j] *= sign;
}

/* The way off a saddle or a top: down along the direction that bends most. */
static bool leave(const struct nearest *q, const struct model *w, double *p)
{
    int least = -1;
    for (int k = 0; k < w->dim; k++)
        if (w->value[k] < -FLAT && (least < 0 || w->value[k] < w->value[least]))
            least = k;
    memset(p, 0, (size_t)q->t->n * sizeof *p);
    if (least >= 0)
        along(q, w, least, AWAY, p);
    turn_upwards(q, p);
    return least >= 0;
}

/* x + p, or as much of it as makes the sum lower, on the set. */
static bool advance(const struct nearest *q, double *x, const double *p, double fall)
{
    struct tangent *t = q->t;
    int n = t->n;
    double *y = sga_malloc((size_t)(n + 1) * sizeof *y), before = nearest_sum(q, x), share = 1, length = sqrt(dot(p, p, n));
    bool ok = false;
    for (int half = 0; half < HALVES && !ok && sga_watch_ok(); half++, share /= 2) {
        for (int j = 0; j < n; j++)
            y[j] = t->fixed[j] ? x[j] : x[j] + share * p[j] * t->unit[j];
        ok = tangent_settle(t, q->time, y, INFINITY, SETTLE, NULL)
             && (nearest_sum(q, y) < before - 1e-4 * share * fall || share * length < SHORT);
    }
    if (ok)
        memcpy(x, y, (size_t)n * sizeof *x);
    free(y);
    return ok;
}

static void gradient_of(const struct nearest *q, const double *x, double *g)
{
    for (int j = 0; j < q->t->n; j++)
        g[j] = q->t->fixed[j] || !(q->weight[j] > 0) ? 0 : q->weight[j] * part(q, x, j);
}

/* Tangent vectors at x, those free of charge in units of what they are there. */
static bool basis_by_size(const struct nearest *q, const double *x)
{
    struct tangent *t = q->t;
    const double *unit = t->unit;
    double *size = sga_malloc((size_t)(t->n + 1) * sizeof *size);
    for (int j = 0; j < t->n; j++)
        size[j] = q->weight[j] > 0 ? unit[j] : fmax(unit[j], fabs(x[j]));
    t->unit = size;
    bool ok = tangent_at(t, q->time, x) >= 0;
    if (ok)
        tangent_basis(t);
    t->unit = unit;
    free(size);
    return ok;
}

/* Whether the guess lies across the set as what counts alone sees it: along a tangent vector that is nearly all free of charge the
 * sum is level too, however far its end is. */
static bool at_end(const struct nearest *q, const double *x)
{
    struct tangent *t = q->t;
    int n = t->n;
    if (!basis_by_size(q, x))
        return false;
    size_t d = (size_t)t->dim, room = d * (size_t)n + d * d + d + 2 * (size_t)n + 1;
    double *M = sga_calloc(room, sizeof *M), *work = M + d * (size_t)n, *g = work + d * d + d, *v = g + n;
    int *perm = sga_calloc(d + 1, sizeof *perm), rows = 0;
    gradient_of(q, x, g);
    for (int k = 0; k < t->dim; k++) {
        double *row = M + (size_t)rows * (size_t)n;
        for (int j = 0; j < n; j++)
            row[j] = q->weight[j] > 0 ? t->basis[(size_t)k * (size_t)n + (size_t)j] : 0;
        rows += sqrt(dot(row, row, n)) > FAINT;
    }
    if (rows < t->dim)
        memset(M + (size_t)rows * (size_t)n, 0, (size_t)n * sizeof *M);
    int rank = rows ? points_least_norm_factor(rows, n, M, perm, work) : 0;
    double whole = dot(g, g, n), along = whole;
    assert(rank <= rows && rows <= t->dim);
    t->effort += 4.0 * rank * n * (n - rank);
    for (int k = 0; k < n - rank; k++) {
        points_least_norm_kernel(n, M, rank, perm, work, k, v);
        along -= dot(v, g, n) * dot(v, g, n);
    }
    free(M);
    free(perm);
    return sqrt(fmax(along, 0)) <= LEVEL * sqrt(whole) + TINY;
}

bool nearest_descend(const struct nearest *q, double *x)
{
    struct model w;
    int n = q->t->n;
    double *p = sga_malloc((size_t)(n + 1) * sizeof *p), steep = INFINITY;
    bool more = true;
    model_init(&w, q->t);
    for (int k = 0, last = 0; k < STEPS && more && sga_watch_ok(); k++) {
        gradient_of(q, x, w.full);
        if (!look(q, &w, x, w.full, true) || w.dim == 0)
            break;
        bool flat = w.steep <= ROUNDING * w.size;
        if (flat || w.size == 0) {
            more = w.size > 0 && leave(q, &w, p) && advance(q, x, p, 0);
            steep = INFINITY;
            continue;
        }
        newton(q, &w, p);
        double length = sqrt(dot(p, p, n));
        last = length < SHORT ? last + 1 : 0;
        more = length > 0 && (last < 2 || w.steep < 0.5 * steep) && advance(q, x, p, -dot(p, w.full, n));
        steep = w.steep;
    }
    free(p);
    free(w.gradient);
    return at_end(q, x);
}

bool nearest_least(const struct nearest *q, const double *x)
{
    struct model w;
    model_init(&w, q->t);
    gradient_of(q, x, w.full);
    bool least = look(q, &w, x, w.full, true);
    for (int k = 0; k < w.dim && least; k++)
        least = w.value[k] > -FLAT;
    free(w.gradient);
    return least;
}

static bool moves_none(const struct nearest *q, const double *p)
{
    double sum = 0;
    for (int j = 0; j < q->t->n; j++)
        sum += q->weight[j] > 0 ? p[j] * p[j] : 0;
    return sum < FLAT;
}

/* The linear condition that keeps the gradient along the set at 0: of the variables that the sum fixes alone, where the direction
 * itself has those that follow from them too. */
static void bar(const struct nearest *q, const struct model *w, int k, double *p)
{
    int n = q->t->n;
    memset(p, 0, (size_t)n * sizeof *p);
    for (int i = 0; i < w->dim; i++)
        for (int j = 0; j < n; j++)
            p[j] += w->vector[k * w->dim + i] * w->bent[(size_t)i * (size_t)n + (size_t)j];
    double size = sqrt(dot(p, p, n));
    for (int j = 0; j < n; j++)
        p[j] /= size;
    tangent_bar(q->t, p);
}

void nearest_bar(const struct nearest *q, const double *x, bool edge)
{
    struct model w;
    int n = q->t->n;
    double *p = sga_malloc((size_t)(n + 1) * sizeof *p);
    model_init(&w, q->t);
    gradient_of(q, x, w.full);
    if (look(q, &w, x, w.full, true))
        for (int k = 0; k < w.dim; k++)
            if (bends(q, &w, k, p)) {
                if (!edge || moves_none(q, p))
                    bar(q, &w, k, p);
            }
    free(p);
    free(w.gradient);
}

void nearest_refine(const struct nearest *q, const double *x, const double *gradient, double *step)
{
    struct model w;
    model_init(&w, q->t);
    memset(step, 0, (size_t)q->t->n * sizeof *step);
    gradient_of(q, x, w.full);
    if (look(q, &w, x, w.full, true)) {
        for (int k = 0; k < w.dim; k++)
            w.gradient[k] = dot(q->t->basis + (size_t)k * (size_t)q->t->n, gradient, q->t->n);
        newton(q, &w, step);
    }
    free(w.gradient);
}
