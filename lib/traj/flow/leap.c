/* See leap.h. The ramp is a motion of its own, by explicit steps, and its end is polished. */
#include "leap.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "flow.h"
#include "jacobian.h"
#include "lin_dense.h"
#include "manifold.h"
#include "mem.h"
#include "ode.h"
#include "sides.h"
#include "tape.h"
#include "watch.h"

enum { MOST_STEPS = 1000, POLISH = 6 };

static const double RANK = 1e-10;     /* of the largest singular value */
static const double FIRM = 1e-6;      /* of a row: no doubt of the rank */
static const double MET = 1e-9;       /* of the right side: the equations of a direction hold, */
static const double NOISE = 1e-12;    /* or to this, in natural units: roundings */
static const double NO_JUMP = 1e-9;   /* of a row, in natural units: what a point beside the surface misses */
static const double SAME = 1e-14;     /* of a variable, in its unit: errors of steps along the ramp */
static const double ALIKE = 1e-8;     /* of a variable, in its unit: ends of ramps of different shapes that agree */

static bool jumps(enum expr_op op) { return points_switches(op) && op != EXPR_ABS && op != EXPR_MIN && op != EXPR_MAX; }

/* Entries that jump by themselves: what they say at the place of the jump is not known. */
static bool has_jump(const struct expr_store *st, const expr_id *root, int count)
{
    struct expr_cone cone;
    bool has = false;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, root, count);
    for (int k = 0; k < cone.count && !has; k++)
        has = jumps(expr_op_of(st, cone.list[k]));
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
    l->undecided_t = NAN;
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
    assert(l->entries == entries && l->rows <= sys->rows);
    for (int j = 0; j < n; j++)
        inputs[j] = sys->variable[j].symbol;
    inputs[n] = sys->time;
    bool ok = true;
    if (has_jump(sys->store, root, entries)) {
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
        A[l->row[k] * n + l->col[k]] += value[k] * f->manifold->unit[l->col[k]];
    even_rows(A, NULL, l->rows, n);
    free(in);
    return ok;
}

struct ramp {
    struct flow *f;
    double t;
    double *lost, *left;          /* by constraint: what it loses along the ramp, and what stays as it is: no jump, but what a point beside the surface misses */
    bool bent;                    /* every second loss falls as 1 - s^2 */
    double *a, *b, *r, *d;        /* (c + rows) x n, c + rows, c, n */
    double *work;                 /* (c + rows) x (n + 1) */
};

/* a d = b, rows x n of rank n by its rows' largest entries, by elimination. *missed: what of b is left. False: the rank is less. */
static bool eliminate(const struct ramp *p, int rows, double *missed)
{
    int n = p->f->n, wide = n + 1;
    double *w = p->work;
    for (int i = 0; i < rows; i++) {
        memcpy(w + (size_t)i * (size_t)wide, p->a + (size_t)i * (size_t)n, (size_t)n * sizeof *w);
        w[i * wide + n] = p->b[i];
    }
    for (int j = 0; j < n; j++) {
        int best = j;
        for (int i = j; i < rows; i++)
            best = fabs(w[i * wide + j]) > fabs(w[best * wide + j]) ? i : best;
        if (best >= rows || !(fabs(w[best * wide + j]) > FIRM))
            return false;
        for (int k = j; k < wide && best != j; k++) {
            double v = w[best * wide + k];
            w[best * wide + k] = w[j * wide + k];
            w[j * wide + k] = v;
        }
        for (int i = j + 1; i < rows; i++) {
            double q = w[i * wide + j] / w[j * wide + j];
            for (int k = j + 1; k < wide && q != 0; k++)
                w[i * wide + k] -= q * w[j * wide + k];
        }
    }
    *missed = 0;
    for (int i = n; i < rows; i++)
        *missed = fmax(*missed, fabs(w[i * wide + n]));
    for (int j = n - 1; j >= 0; j--) {
        double v = w[j * wide + n];
        for (int k = j + 1; k < n; k++)
            v -= w[j * wide + k] * p->d[k];
        p->d[j] = v / w[j * wide + j];
    }
    return true;
}

/* d: with the constraints' derivatives along it b (the first c), and in the kernel. False: there is none. */
static bool direction(struct ramp *p, const double *x)
{
    struct manifold *m = p->f->manifold;
    int n = m->n, c = m->c, rows = c + p->f->leap->rows;
    struct lin_least least;
    double size = 0, missed;
    memset(p->a, 0, (size_t)c * (size_t)n * sizeof *p->a);
    for (int i = 0; i < c; i++)
        for (int e = m->jac->start[i]; e < m->jac->start[i + 1]; e++)
            p->a[i * n + m->jac->col[e]] = m->value[e] * m->unit[m->jac->col[e]];
    even_rows(p->a, p->b, c, n);
    memset(p->b + c, 0, (size_t)(rows - c) * sizeof *p->b);
    for (int i = 0; i < c; i++)
        size = fmax(size, fabs(p->b[i]));
    if (!leap_rows(p->f, p->t, x, p->a + (size_t)c * (size_t)n))
        return false;
    if (!eliminate(p, rows, &missed)) {       /* near a fold, or where some are free */
        if (!lin_least_norm(&(struct lin_dense){ rows, n, p->a }, p->b, RANK, p->d, &least))
            return false;
        missed = least.residual;
    }
    return missed <= fmax(MET * size, NOISE);
}

/* Constraints and their derivatives at x. */
static bool constraints(struct ramp *p, const double *x)
{
    struct manifold *m = p->f->manifold;
    memcpy(m->in, x, (size_t)m->n * sizeof *x);
    m->in[m->n] = p->t;
    return num_jacobian_eval(m->jac, m->in, p->r, m->value);
}

/* dx/ds of the ramp, in the units of the variables. */
static bool rate(void *ctx, double s, const double *x, double *k)
{
    struct ramp *p = ctx;
    bool ok = sga_watch_ok() && constraints(p, x);
    for (int i = 0; i < p->f->manifold->c; i++)
        p->b[i] = -p->lost[i] * (p->bent && i % 2 ? 2 * s : 1);
    ok = ok && direction(p, x);
    for (int j = 0; j < p->f->n && ok; j++)
        k[j] = p->d[j] * p->f->manifold->unit[j];
    return ok;
}

static double apart(const struct flow *f, const double *x, const double *y)
{
    double most = 0;
    for (int j = 0; j < f->n; j++)
        most = fmax(most, fabs(x[j] - y[j]) / (f->manifold->unit[j] + fabs(y[j])));
    return most;
}

/* Newton's steps in the kernel to where the constraints hold to rounding. */
static bool polish(struct ramp *p, double *x)
{
    struct manifold *m = p->f->manifold;
    bool ok = true;
    for (int k = 0; k < POLISH && ok; k++) {
        ok = constraints(p, x);
        for (int i = 0; i < m->c; i++)
            p->b[i] = p->left[i] - p->r[i];
        ok = ok && direction(p, x);
        for (int j = 0; j < m->n && ok; j++)
            x[j] += p->d[j] * m->unit[j];
    }
    assert(!m->target);       /* nobody else aims elsewhere */
    m->target = p->left;
    ok = ok && manifold_settled(m, x, NULL, manifold_residual(m, p->t, x, NULL, NULL));
    m->target = NULL;
    return ok;
}

/* The end of a ramp from x. */
static bool ramp_end(struct ramp *p, const double *x, double *end)
{
    struct ode_problem problem = { .n = p->f->n, .ctx = p, .rhs = rate };
    struct ode_start start = { .x = x, .count = 1, .times = (double[]){ 1 } };
    struct ode_options options = ode_options_default();
    struct ode_result r;
    options.method = "dop853";
    options.rtol = options.atol = SAME;
    options.unit = p->f->manifold->unit;
    options.max_steps = MOST_STEPS;
    if (!ode_solve(&problem, &start, &options, &r, NULL))
        return false;
    bool ok = r.count == 1 && r.end.reason == ODE_NONE;
    if (ok)
        memcpy(end, r.samples, (size_t)p->f->n * sizeof *end);
    ok = ok && polish(p, end) && apart(p->f, r.samples, end) <= ALIKE;      /* not on another branch */
    ode_result_free(&r);
    return ok;
}

bool leap_over(struct flow *f, double t, double *x)
{
    struct manifold *m = f->manifold;
    if (!f->leap || !m->c)
        return false;
    size_t n = (size_t)m->n, c = (size_t)m->c, rows = c + (size_t)f->leap->rows;
    double *all = sga_calloc(rows * (2 * n + 2) + 3 * c + 3 * n + 1, sizeof *all), *work = all + rows * (n + 1), *lost = work + rows * (n + 1), *end = lost + 3 * c + n;
    double *other = end + n;
    struct ramp p = { .f = f, .t = t, .lost = lost, .left = lost + c, .a = all, .b = all + rows * n, .r = lost + 2 * c, .d = lost + 3 * c, .work = work };
    memcpy(m->in, x, n * sizeof *x);
    m->in[n] = t;
    bool ok = num_tape_eval(m->tape, m->in, lost) && manifold_residual(m, t, x, NULL, NULL) >= 0;
    for (size_t i = 0; i < c && ok; i++)
        if (fabs(m->r[i]) <= NO_JUMP) {
            p.left[i] = lost[i];
            lost[i] = 0;
        }
    ok = ok && ramp_end(&p, x, end);
    p.bent = true;
    ok = ok && ramp_end(&p, x, other);
    if (ok && !(apart(f, end, other) <= ALIKE)) {
        f->leap->undecided_t = t;
        ok = false;
    }
    if (ok)
        memcpy(x, end, n * sizeof *x);
    free(all);
    return ok;
}
