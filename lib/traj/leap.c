/* See leap.h. The ramp is integrated by Runge and Kutta's method, with twice as many steps until nothing changes, and its end is polished. */
#include "leap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "flow.h"
#include "jacobian.h"
#include "lin_dense.h"
#include "mem.h"
#include "sides.h"
#include "tape.h"

enum { FEWEST = 4, STEPS = 512, POLISH = 6 };

static const double RANK = 1e-10;     /* of the largest singular value */
static const double MET = 1e-9;       /* of the right side: the equations of a direction hold */
static const double SAME = 1e-11;     /* of a variable, in its unit: ends that agree */
static const double ALIKE = 1e-8;     /* as SAME, of ramps of different shapes */

/* Entries that jump by themselves: what they say at the place of the jump is not known. */
static bool has_switch(const struct expr_store *st, const expr_id *root, int count)
{
    struct expr_cone cone;
    bool has = false;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, root, count);
    for (int k = 0; k < cone.count && !has; k++)
        has = points_switches(expr_op_of(st, cone.list[k]));
    expr_cone_clear(&cone);
    return has;
}

bool leap_init(struct leap **out, const struct sys_system *sys, const struct num_switches *w, struct sga_error *err)
{
    int n = sys->variables, entries = 0;
    bool sums = false;
    for (int i = 0; i < sys->rows; i++) {
        entries += sys->row[i].entries;
        sums |= sys->row[i].entries > 1;
    }
    *out = NULL;
    if (!sums || !w || !w->count || n > LEAP_MOST)
        return true;
    struct leap *l = *out = sga_calloc(1, sizeof *l);
    expr_id *root = sga_malloc((size_t)entries * sizeof *root);
    int *inputs = sga_malloc((size_t)(n + 1) * sizeof *inputs);
    l->row = sga_malloc((size_t)entries * sizeof *l->row);
    l->col = sga_malloc((size_t)entries * sizeof *l->col);
    for (int i = 0; i < sys->rows; i++) {
        for (int k = 0; k < sys->row[i].entries; k++, l->entries++) {
            root[l->entries] = sys->row[i].entry[k].value;
            l->row[l->entries] = l->rows;
            l->col[l->entries] = sys->row[i].entry[k].col;
        }
        l->rows += sys->row[i].entries > 0;
    }
    for (int j = 0; j < n; j++)
        inputs[j] = sys->variable[j].symbol;
    inputs[n] = sys->time;
    bool jumps = has_switch(sys->store, root, entries), ok = true;
    if (jumps) {
        leap_clear(l);
        *out = NULL;
    } else {
        l->tape = num_tape_new(sys->store, root, entries, inputs, n + 1, err);
        ok = l->tape != NULL;
    }
    free(root);
    free(inputs);
    return ok;
}

void leap_clear(struct leap *l)
{
    if (!l)
        return;
    num_tape_free(l->tape);
    free(l->row);
    free(l->col);
    free(l);
}

/* Rows by their largest entries, b with them if it is given. */
static void even_rows(double *a, double *b, int rows, int n)
{
    for (int i = 0; i < rows; i++) {
        double most = 0;
        for (int j = 0; j < n; j++)
            most = fmax(most, fabs(a[i * n + j]));
        for (int j = 0; j < n && most > 0; j++)
            a[i * n + j] /= most;
        if (b && most > 0)
            b[i] /= most;
    }
}

bool leap_rows(const struct flow *f, double t, const double *x, double *A)
{
    const struct leap *l = f->leap;
    int n = f->n;
    double *in = sga_malloc(((size_t)n + 1 + (size_t)l->entries) * sizeof *in), *value = in + n + 1;
    memcpy(in, x, (size_t)n * sizeof *in);
    in[n] = t;
    bool ok = num_tape_eval(l->tape, in, value);
    memset(A, 0, (size_t)l->rows * (size_t)n * sizeof *A);
    for (int k = 0; k < l->entries && ok; k++)
        A[l->row[k] * n + l->col[k]] += value[k] * f->manifold.unit[l->col[k]];
    even_rows(A, NULL, l->rows, n);
    free(in);
    return ok;
}

struct ramp {
    struct flow *f;
    double t;
    const double *lost;           /* by constraint */
    bool bent;                    /* every second loss falls as 1 - s^2 */
    double *a, *b, *r, *d;        /* (c + rows) x n, c + rows, c, n */
};

/* d: with the constraints' derivatives along it b (the first c), and in the kernel. False: there is none. */
static bool direction(struct ramp *p, const double *x)
{
    struct manifold *m = &p->f->manifold;
    int n = m->n, c = m->c, rows = c + p->f->leap->rows;
    struct lin_least least;
    double size = 0;
    memset(p->a, 0, (size_t)c * (size_t)n * sizeof *p->a);
    for (int i = 0; i < c; i++)
        for (int e = m->jac->start[i]; e < m->jac->start[i + 1]; e++)
            p->a[i * n + m->jac->col[e]] = m->value[e] * m->unit[m->jac->col[e]];
    even_rows(p->a, p->b, c, n);
    memset(p->b + c, 0, (size_t)(rows - c) * sizeof *p->b);
    for (int i = 0; i < c; i++)
        size = fmax(size, fabs(p->b[i]));
    return leap_rows(p->f, p->t, x, p->a + (size_t)c * (size_t)n)
           && lin_least_norm(&(struct lin_dense){ rows, n, p->a }, p->b, RANK, p->d, &least) && least.residual <= MET * fmax(size, SAME);
}

/* Constraints and their derivatives at x. */
static bool constraints(struct ramp *p, const double *x)
{
    struct manifold *m = &p->f->manifold;
    memcpy(m->in, x, (size_t)m->n * sizeof *x);
    m->in[m->n] = p->t;
    return num_jacobian_eval(m->jac, m->in, p->r, m->value);
}

/* dx/ds of the ramp, in the units of the variables. */
static bool rate(struct ramp *p, double s, const double *x, double *k)
{
    bool ok = constraints(p, x);
    for (int i = 0; i < p->f->manifold.c; i++)
        p->b[i] = -p->lost[i] * (p->bent && i % 2 ? 2 * s : 1);
    ok = ok && direction(p, x);
    for (int j = 0; j < p->f->n && ok; j++)
        k[j] = p->d[j] * p->f->manifold.unit[j];
    return ok;
}

static bool march(struct ramp *p, int steps, double *x)
{
    int n = p->f->n;
    double *k = sga_malloc(3 * ((size_t)n + 1) * sizeof *k), *sum = k + n, *y = sum + n, h = 1.0 / steps;
    bool ok = true;
    for (int i = 0; i < steps && ok; i++) {
        static const double at[] = { 0, 0.5, 0.5, 1 }, weight[] = { 1, 2, 2, 1 };
        memset(sum, 0, (size_t)n * sizeof *sum);
        memset(k, 0, (size_t)n * sizeof *k);
        for (int q = 0; q < 4 && ok; q++) {
            for (int j = 0; j < n; j++)
                y[j] = x[j] + h * at[q] * k[j];
            ok = rate(p, (i + at[q]) * h, y, k);
            for (int j = 0; j < n; j++)
                sum[j] += weight[q] / 6 * k[j];
        }
        for (int j = 0; j < n; j++)
            x[j] += h * sum[j];
    }
    free(k);
    return ok;
}

/* Newton's steps in the kernel to where the constraints hold to rounding. */
static bool polish(struct ramp *p, double *x)
{
    struct manifold *m = &p->f->manifold;
    bool ok = true;
    for (int k = 0; k < POLISH && ok; k++) {
        ok = constraints(p, x);
        for (int i = 0; i < m->c; i++)
            p->b[i] = -p->r[i];
        ok = ok && direction(p, x);
        for (int j = 0; j < m->n && ok; j++)
            x[j] += p->d[j] * m->unit[j];
    }
    return ok && manifold_settled(m, x, NULL, manifold_residual(m, p->t, x, NULL, NULL));
}

static double apart(const struct flow *f, const double *x, const double *y)
{
    double most = 0;
    for (int j = 0; j < f->n; j++)
        most = fmax(most, fabs(x[j] - y[j]) / (f->manifold.unit[j] + fabs(y[j])));
    return most;
}

/* The end of a ramp from x. */
static bool ramp_end(struct ramp *p, const double *x, double *end)
{
    size_t n = (size_t)p->f->n;
    double *before = sga_malloc((n + 1) * sizeof *before);
    bool ok = true, same = false;
    for (int steps = FEWEST; steps <= STEPS && ok && !same; steps *= 2) {
        memcpy(end, x, n * sizeof *x);
        ok = march(p, steps, end);
        same = ok && steps > FEWEST && apart(p->f, before, end) <= SAME;
        memcpy(before, end, n * sizeof *end);
    }
    free(before);
    return ok && same && polish(p, end);
}

bool leap_over(struct flow *f, double t, double *x)
{
    struct manifold *m = &f->manifold;
    if (!f->leap || !m->c)
        return false;
    size_t n = (size_t)m->n, c = (size_t)m->c, rows = c + (size_t)f->leap->rows;
    double *all = sga_calloc(rows * n + rows + 2 * c + 3 * n + 1, sizeof *all), *lost = all + rows * n + rows, *end = lost + 2 * c + n, *other = end + n;
    struct ramp p = { .f = f, .t = t, .lost = lost, .a = all, .b = all + rows * n, .r = lost + c, .d = lost + 2 * c };
    memcpy(m->in, x, n * sizeof *x);
    m->in[n] = t;
    bool ok = num_tape_eval(m->tape, m->in, lost) && ramp_end(&p, x, end);
    p.bent = true;
    ok = ok && ramp_end(&p, x, other) && apart(f, end, other) <= ALIKE;
    if (ok)
        memcpy(x, end, n * sizeof *x);
    free(all);
    return ok;
}
