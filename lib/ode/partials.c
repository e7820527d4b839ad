/* Jacobians; differences by groups of columns (Curtis, Powell, Reid, J. Inst. Math.
 * Appl. 13 (1974) 117). */
#include "partials.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lin_sparse.h"
#include "mem.h"
#include "watch.h"

#define DIFFERENCE 6.1e-6      /* eps^(1/3) */
#define FEW 30                 /* variables whose differences take no time */
#define GIVEN_COST 4.0         /* of a Jacobian that the problem gives, in evaluations */

static struct lin_sparse *full(int n)
{
    int *ptr = sga_malloc(((size_t)n + 1) * sizeof *ptr), *col = sga_malloc(((size_t)n * (size_t)n + 1) * sizeof *col);
    ptr[0] = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            col[ptr[i] + j] = j;
        ptr[i + 1] = ptr[i] + n;
    }
    struct lin_sparse *a = lin_sparse_new(n, n, ptr, col);
    free(ptr);
    free(col);
    return a;
}

static void by_columns(struct ode_partials *d)
{
    const struct lin_sparse *a = d->pattern;
    int n = a->cols;
    d->at = sga_calloc((size_t)n + 2, sizeof *d->at);
    d->entry = sga_malloc(((size_t)a->ptr[n] + 1) * sizeof *d->entry);
    for (int k = 0; k < a->ptr[n]; k++)
        d->at[a->col[k] + 2]++;
    for (int j = 0; j < n; j++)
        d->at[j + 1] += d->at[j];
    for (int k = 0; k < a->ptr[n]; k++)
        d->entry[d->at[a->col[k] + 1]++] = k;
    assert(d->at[n] == a->ptr[n]);       /* each entry is in one column */
}

static bool has_full_row(const struct lin_sparse *a)
{
    for (int i = 0; i < a->rows; i++)
        if (a->ptr[i + 1] - a->ptr[i] == a->cols)
            return true;
    return false;
}

/* Greedily, each column into the first group that none of its rows is in. */
static void colour(struct ode_partials *d)
{
    const struct lin_sparse *a = d->pattern;
    int n = a->cols, *used = sga_malloc(((size_t)n + 1) * sizeof *used);
    int *row = sga_malloc(((size_t)a->ptr[n] + 1) * sizeof *row);
    for (int i = 0; i < n; i++)
        for (int k = a->ptr[i]; k < a->ptr[i + 1]; k++)
            row[k] = i;
    d->group = sga_malloc(((size_t)n + 1) * sizeof *d->group);
    for (int j = 0; j < n; j++) {
        d->group[j] = -1;
        used[j] = -1;
    }
    bool alone = has_full_row(a);
    for (int j = 0; alone && j < n; j++)
        d->group[j] = d->groups++;
    for (int j = 0; !alone && j < n; j++) {
        for (int e = d->at[j]; e < d->at[j + 1]; e++) {
            int i = row[d->entry[e]];
            for (int k = a->ptr[i]; k < a->ptr[i + 1]; k++)
                if (d->group[a->col[k]] >= 0)
                    used[d->group[a->col[k]]] = j;
        }
        int g = 0;
        while (g < d->groups && used[g] == j)
            g++;
        d->group[j] = g;
        d->groups = g == d->groups ? g + 1 : d->groups;
    }
    assert(d->groups <= n && (d->groups > 0 || n == 0));
    free(used);
    free(row);
}

void ode_partials_init(struct ode_partials *d, const struct ode_problem *p, const struct lin_sparse *known)
{
    size_t n = (size_t)p->n;
    *d = (struct ode_partials){.p = p};
    d->pattern = known ? lin_sparse_new(p->n, p->n, known->ptr, known->col) : full(p->n);
    d->x = sga_malloc((5 * n + 1) * sizeof *d->x);
    d->up = d->x + n;
    d->down = d->up + n;
    d->delta = d->down + n;
    d->scale = d->delta + n;
}

void ode_partials_clear(struct ode_partials *d)
{
    lin_sparse_free(d->pattern);
    free(d->group);
    free(d->at);
    free(d->entry);
    free(d->x);
}

/* The field at the start with group g moved; where it is refused, the start itself stands
 * for it. With constraints the moved point is brought back to them: off the manifold a
 * field may be anything, and along it is where the stages are. */
static const double *moved(struct ode_partials *d, struct ode_field *field, const struct ode_step *s,
                           int g, double sign, double *out)
{
    for (int j = 0; j < s->n; j++)
        d->x[j] = s->x[j] + (d->group[j] == g ? sign * d->delta[j] : 0);
    const struct ode_problem *p = d->p;
    double far, residual;
    if (p->project && !p->pattern) {
        for (int j = 0; j < s->n; j++)
            d->scale[j] = ode_allowed(s->rtol, s->atol, s->unit[j], s->x[j], s->x[j]);
        field->stats->projections++;
        if (!p->project(p->ctx, s->t, d->x, d->scale, &far, &residual))
            return s->f;
    }
    return ode_eval(field, s->t, d->x, out) ? out : s->f;
}

static bool differences(struct ode_partials *d, struct ode_field *field, const struct ode_step *s, double *value,
                        double *cost)
{
    const struct lin_sparse *a = d->pattern;
    if (!d->group) {
        by_columns(d);
        colour(d);
    }
    for (int j = 0; j < s->n; j++) {
        double size = fmax(fabs(s->x[j]), 10 * ode_allowed(s->rtol, s->atol, s->unit[j], s->x[j], s->x[j]));
        volatile double there = s->x[j] + DIFFERENCE * size;    /* so that it is exact */
        d->delta[j] = there - s->x[j];
    }
    bool finite = true;
    for (int g = 0; g < d->groups; g++) {
        if (s->n > FEW && !sga_watch_ok())
            return false;
        const double *up = moved(d, field, s, g, 1, d->up), *down = moved(d, field, s, g, -1, d->down);
        double span = (up == d->up) + (down == d->down);
        for (int i = 0; i < s->n; i++)
            for (int k = a->ptr[i]; k < a->ptr[i + 1]; k++)
                if (d->group[a->col[k]] == g) {
                    value[k] = (up[i] - down[i]) / (span * d->delta[a->col[k]]);
                    finite &= (bool)isfinite(value[k]);
                }
    }
    *cost = 2.0 * d->groups;
    return finite;
}

bool ode_partials_eval(struct ode_partials *d, struct ode_field *field, const struct ode_step *step,
                       double *value, double *cost)
{
    const struct ode_problem *p = d->p;
    field->stats->jacobians++;
    *cost = GIVEN_COST;
    if (p->jacobian && p->jacobian(p->ctx, step->t, step->x, value) &&
        lin_all_finite(d->pattern->ptr[p->n], value))
        return true;
    return differences(d, field, step, value, cost);
}
