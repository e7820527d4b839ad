/* Tangent spaces by a pivoted QR of the constraints' differentials: see tangent.h. */
#include "tangent.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "jacobian.h"
#include "larger.h"
#include "leastnorm.h"
#include "mem.h"
#include "normal.h"
#include "watch.h"

/* A residual that no longer falls may be this large, in units of the variables. */
static const double STALLED = 1e-11;
/* Part of the residual that no step reaches: more than this twice running, and there is no way. */
static const double BEYOND = 0.5;
/* Pivots below this are none. */
static const double NOTHING = 1e-14;
/* Later steps together below this part of the first one: the constraints are nearly affine here. */
static const double EASY = 0.1;

void tangent_init(struct tangent *t, struct manifold *m, const double *unit)
{
    size_t n = (size_t)m->n, c = (size_t)m->c;
    *t = (struct tangent){ .m = m, .unit = unit, .n = m->n, .c = m->c };
    t->fixed = sga_calloc(n + 1, 1);
    t->column = sga_calloc(n + 1, sizeof *t->column);
    t->r = sga_calloc(c + 1, sizeof *t->r);
    t->v = sga_calloc(c + 2 * n + 1, sizeof *t->v);
    t->y = sga_calloc(c + n + 1, sizeof *t->y);
    t->perm = sga_calloc(c + n + 1, sizeof *t->perm);
    t->slope = sga_calloc(n + 1, sizeof *t->slope);
    tangent_fix(t);
}

/* What is as large as a square of the variables, once it is used. */
static void enlarge(struct tangent *t)
{
    size_t n = (size_t)t->n, rows = (size_t)t->c + n;
    if (t->J)
        return;
    t->barred = sga_calloc(n * n + 1, sizeof *t->barred);
    t->basis = sga_calloc(n * n + 1, sizeof *t->basis);
    t->J = sga_calloc(rows * n + 1, sizeof *t->J);
    t->work = sga_calloc(rows * (rows + 1) + 1, sizeof *t->work);
}

void tangent_clear(struct tangent *t)
{
    free(t->fixed);
    free(t->column);
    free(t->barred);
    free(t->r);
    free(t->basis);
    free(t->v);
    free(t->y);
    free(t->perm);
    free(t->slope);
    free(t->J);
    free(t->work);
}

void tangent_fix(struct tangent *t)
{
    t->columns = 0;
    for (int j = 0; j < t->n; j++)
        if (!t->fixed[j])
            t->column[t->columns++] = j;
}

void tangent_bar(struct tangent *t, const double *d)
{
    if (t->bars < t->n)
        memcpy(t->barred + (size_t)t->bars++ * (size_t)t->n, d, (size_t)t->n * sizeof *d);
}

/* Row i of the differentials in the columns that move, from all n of slope. */
static void take_row(struct tangent *t, int i, const double *slope)
{
    for (int k = 0; k < t->columns; k++)
        t->J[(size_t)i * (size_t)t->columns + (size_t)k] = slope[t->column[k]];
}

double tangent_at(struct tangent *t, double time, const double *x)
{
    struct manifold *m = t->m;
    double worst = manifold_residual(m, time, x, t->unit, NULL);
    if (worst < 0)
        return -1;
    enlarge(t);
    t->effort += 2.0 * (t->c + t->bars) * (t->c + t->bars) * t->columns;
    sga_copy(t->r, m->r, t->c);
    for (int i = 0; i < t->c; i++) {
        memset(t->slope, 0, (size_t)t->n * sizeof *t->slope);
        for (int k = 0; k < m->cols[i]; k++)
            t->slope[m->col[i][k]] = m->step->value[i][k];
        take_row(t, i, t->slope);
    }
    for (int i = 0; i < t->bars; i++)
        take_row(t, t->c + i, t->barred + (size_t)i * (size_t)t->n);
    t->rank = t->columns ? points_least_norm_factor(t->c + t->bars, t->columns, t->J, t->perm, t->work) : 0;
    size_t rows = (size_t)t->c + (size_t)t->bars;
    assert(t->rank <= t->columns && (size_t)t->rank <= rows);
    for (t->least = 1; t->rank; t->rank--) {       /* rows have 1 as their largest entry, fixed variables among them */
        size_t last = (size_t)t->rank - 1;
        t->least = fabs(t->work[rows + last * rows + last]);
        if (t->least > NOTHING)
            break;
    }
    return worst;
}

static void spread(const struct tangent *t, const double *v, double *d)
{
    memset(d, 0, (size_t)t->n * sizeof *d);
    for (int k = 0; k < t->columns; k++)
        d[t->column[k]] = v[k];
}

void tangent_basis(struct tangent *t)
{
    t->dim = t->columns - t->rank;
    assert(t->dim >= 0 && t->dim <= t->n);
    t->effort += 4.0 * t->rank * t->columns * t->dim;
    for (int k = 0; k < t->dim; k++) {
        points_least_norm_kernel(t->columns, t->J, t->rank, t->perm, t->work, k, t->v);
        spread(t, t->v, t->basis + (size_t)k * (size_t)t->n);
    }
}

double tangent_normal(struct tangent *t, double *d)
{
    double left = 0, *r = t->v + t->n;
    memset(r, 0, (size_t)(t->c + t->bars) * sizeof *r);
    sga_copy(r, t->r, t->c);
    if (t->columns)
        points_least_norm_solve(t->c + t->bars, t->columns, t->J, t->rank, t->perm, t->work, r, t->v);
    spread(t, t->v, d);
    for (int i = 0; i < t->c; i++) {
        double sum = t->r[i];
        for (int k = 0; k < t->m->cols[i]; k++)
            sum += t->m->step->value[i][k] * d[t->m->col[i][k]];
        left = sga_larger(left, fabs(sum));
    }
    return left;
}

/* The factors' last direction is what the row that comes last has beside the others. */
void tangent_weakest(struct tangent *t, double *y)
{
    double *v = t->v;
    points_least_norm_kernel(t->columns, t->J, t->rank, t->perm, t->work, -1, v);
    memset(t->y, 0, (size_t)(t->c + t->bars) * sizeof *t->y);
    points_least_norm_multipliers(t->c + t->bars, t->columns, t->J, t->rank, t->perm, t->work, v, t->y);
    sga_copy(y, t->y, t->c);
}

void tangent_multipliers(struct tangent *t, const double *v, double *y)
{
    for (int k = 0; k < t->columns; k++)
        t->v[k] = v[t->column[k]];
    memset(t->y, 0, (size_t)(t->c + t->bars) * sizeof *t->y);
    if (t->columns)
        points_least_norm_multipliers(t->c + t->bars, t->columns, t->J, t->rank, t->perm, t->work, t->v, t->y);
    sga_copy(y, t->y, t->c);
}

bool tangent_gradient(struct tangent *t, double time, const double *x, const double *y, const double *big, double *g)
{
    struct manifold *m = t->m;
    sga_copy(m->in, x, t->n);
    m->in[t->n] = time;
    if (!num_jacobian_eval(m->jac, m->in, m->r, m->value))
        return false;
    memset(g, 0, (size_t)t->n * sizeof *g);
    for (int i = 0; i < t->c; i++)
        for (int k = 0; k < m->cols[i] && y[i] != 0; k++)
            g[m->col[i][k]] += y[i] / big[i] * m->value[m->jac->start[i] + k] * t->unit[m->col[i][k]];
    for (int j = 0; j < t->n; j++)
        if (t->fixed[j])
            g[j] = 0;
    return true;
}

static double length_of(const struct tangent *t, const double *d, double *most)
{
    double sum = 0;
    *most = 0;
    for (int j = 0; j < t->n; j++) {
        sum += d[j] * d[j];
        *most = sga_larger(*most, fabs(d[j]));
    }
    return sqrt(sum);
}

static void step(const struct tangent *t, double *x, const double *d, double part)
{
    for (int j = 0; j < t->n; j++)
        if (!t->fixed[j])
            x[j] += part * d[j] * t->unit[j];
}

/* Half of the step back, until the residual has not grown much. Its value, or -1. */
static double damp(struct tangent *t, double time, double *x, const double *d, double part, double last)
{
    double res = tangent_at(t, time, x);
    for (int half = 0; half < 10 && (res < 0 || res > 4 * last) && sga_watch_ok(); half++) {
        part /= 2;
        step(t, x, d, -part);
        res = tangent_at(t, time, x);
    }
    return res;
}

bool tangent_settle(struct tangent *t, double time, double *x, double longest, int steps, bool *easy)
{
    size_t n = (size_t)t->n;
    double *y = memcpy(sga_malloc((2 * n + 1) * sizeof *y), x, n * sizeof *x), *d = y + n;
    double res = tangent_at(t, time, y), last = INFINITY, first = -1, rest = 0, most;
    int beyond = 0, idle = 0;
    bool ok = false;
    for (int k = 0; res >= 0 && !ok && sga_watch_ok(); k++) {
        ok = manifold_settled(t->m, y, t->unit, res) || (t->m->plain < STALLED && res >= 0.5 * last);
        if (ok || k == steps)
            break;
        double left = tangent_normal(t, d), length = length_of(t, d, &most);
        beyond = left > BEYOND * res ? beyond + 1 : 0;
        idle = res > 0.99 * last && !isfinite(longest) ? idle + 1 : 0;
        if (!(length > 0) || beyond > 1 || idle > 8)
            break;
        first < 0 ? (first = length) : (rest += length);
        last = res;
        double part = most > longest ? longest / most : 1;
        step(t, y, d, part);
        res = damp(t, time, y, d, part, last);
    }
    if (ok)
        memcpy(x, y, n * sizeof *x);
    if (easy)
        *easy = ok && rest <= EASY * first;
    free(y);
    return ok;
}
