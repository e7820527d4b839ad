/* See precise_leap.h. The ramp of leap.c again: x' (s) = d(x), where J(x) d = - what is lost, A(x) d = 0. It is integrated by extrapolation of the midpoint
 * rule (Gragg; Bulirsch and Stoer; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.9), whose error has even powers of the step alone, and
 * its end polished by Newton's steps in the kernel of A. Which way is right, and that there is one only, is for double to say. */
#include "precise_leap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "flow.h"
#include "jet.h"
#include "leap.h"
#include "manifold.h"
#include "mem.h"
#include "watch.h"

enum { COLUMNS = 13, POLISH = 6 };

static const double NO_JUMP = 1e-9;      /* of a row, in natural units, as leap.c has it */
static const double SHORTEST = 1e-7;     /* of the ramp */
static const double HOPE = 1e-7;         /* after half the columns: the others make up for that */
static const double FIRM = 1e-6;         /* of a row: no doubt of the rank */
static const double MET = 1e-22;         /* of the right side: dependent equations agree, */
static const double NOISE = 1e-25;       /* or to this, in natural units */
static const double SETTLED = 1e-29;     /* of a variable, in its unit: columns agree, */
static const double GOOD = 1e-26;        /* or come no nearer and agree to this */
static const double ALIKE = 1e-8;        /* of a variable, in its unit: what double found */

struct ramp {
    struct precise *p;
    struct num_jet2 *kernel;      /* of the entries of A */
    num_dd t, *lost;              /* c: 0 for what does not jump */
    int n, c, rows;
    num_dd *a, *b, *d;            /* rows x (n + 1): equations and right side, used up; c; n: a direction, in units */
};

static void even_row(num_dd *row, int wide)
{
    double most = 0;
    int e;
    for (int j = 0; j < wide - 1; j++)
        most = fmax(most, fabs(row[j].hi));
    if (!(most > 0) || !isfinite(most))
        return;
    frexp(most, &e);
    for (int j = 0; j < wide; j++)
        row[j] = num_dd_scale(row[j], ldexp(1, -e));
}

static void swap_rows(num_dd *a, int wide, int i, int k)
{
    for (int j = 0; j < wide && i != k; j++) {
        num_dd v = a[i * wide + j];
        a[i * wide + j] = a[k * wide + j];
        a[k * wide + j] = v;
    }
}

/* a d = its last column. False: the rank is less than n, or equations contradict each other. */
static bool solve(struct ramp *r)
{
    int n = r->n, wide = n + 1;
    num_dd *a = r->a;
    double size = 0, missed = 0;
    for (int i = 0; i < r->rows; i++)
        size = fmax(size, fabs(a[i * wide + n].hi));
    for (int j = 0; j < n; j++) {
        int best = j;
        for (int i = j; i < r->rows; i++)
            best = fabs(a[i * wide + j].hi) > fabs(a[best * wide + j].hi) ? i : best;
        if (best >= r->rows || !(fabs(a[best * wide + j].hi) > FIRM))
            return false;
        swap_rows(a, wide, best, j);
        for (int i = j + 1; i < r->rows; i++) {
            if (a[i * wide + j].hi == 0)
                continue;
            num_dd q = num_dd_div(a[i * wide + j], a[j * wide + j]);
            for (int k = j + 1; k < wide; k++)
                a[i * wide + k] = num_dd_sub(a[i * wide + k], num_dd_mul(q, a[j * wide + k]));
        }
    }
    for (int i = n; i < r->rows; i++)
        missed = fmax(missed, fabs(a[i * wide + n].hi));
    for (int j = n - 1; j >= 0; j--) {
        num_dd v = a[j * wide + n];
        for (int k = j + 1; k < n; k++)
            v = num_dd_sub(v, num_dd_mul(a[j * wide + k], r->d[k]));
        r->d[j] = num_dd_div(v, a[j * wide + j]);
    }
    return missed <= fmax(MET * size, NOISE);
}

/* r->d: along it the constraints change by r->b, and nothing that is differentiated. */
static bool direction(struct ramp *r, const num_dd *x)
{
    const struct leap *l = r->p->flow->leap;
    const double *unit = r->p->flow->manifold->unit;
    int n = r->n, wide = n + 1;
    num_dd *A = r->a + (size_t)r->c * (size_t)wide;
    if (!sga_watch_ok() || !precise_jacobian(r->p, r->t, x, unit, NULL, r->a))
        return false;
    for (int i = r->c - 1; i >= 0; i--) {      /* rows of n become rows of n + 1 */
        memmove(r->a + (size_t)i * (size_t)wide, r->a + (size_t)i * (size_t)n, (size_t)n * sizeof *r->a);
        r->a[i * wide + n] = r->b[i];
    }
    for (int j = 0; j < n; j++)
        num_jet2_input(r->kernel, j)[0] = x[j];
    num_jet2_input(r->kernel, n)[0] = r->t;
    if (!num_jet2_next(r->kernel, 0))
        return false;
    for (int i = 0; i < l->rows * wide; i++)
        A[i] = num_dd_of(0);
    for (int k = 0; k < l->entries; k++) {
        num_dd *to = A + l->row[k] * wide + l->col[k];
        *to = num_dd_add(*to, num_dd_mul_d(num_jet2_root(r->kernel, k)[0], unit[l->col[k]]));
    }
    for (int i = 0; i < r->rows; i++)
        even_row(r->a + (size_t)i * (size_t)wide, wide);
    return solve(r);
}

/* y = x + h v, v in the variables' units. */
static void add(const struct ramp *r, const num_dd *x, num_dd h, const num_dd *v, num_dd *y)
{
    for (int j = 0; j < r->n; j++)
        y[j] = num_dd_add(x[j], num_dd_mul(num_dd_mul_d(v[j], r->p->flow->manifold->unit[j]), h));
}

/* A part of the ramp by m midpoint steps from x, m even: to `end`. work: n. */
static bool midpoints(struct ramp *r, const num_dd *x, double part, int m, num_dd *end, num_dd *work)
{
    num_dd h = num_dd_div(num_dd_of(part), num_dd_of(m));      /* a rounded one would not come to the end of the part */
    num_dd *before = work, *now = end;
    memcpy(before, x, (size_t)r->n * sizeof *x);
    bool ok = direction(r, x);
    add(r, x, h, r->d, now);
    for (int k = 1; k < m && ok; k++) {
        ok = direction(r, now);
        add(r, before, num_dd_scale(h, 2), r->d, before);
        num_dd *v = before;
        before = now;
        now = v;
    }
    if (now != end)
        memcpy(end, now, (size_t)r->n * sizeof *end);
    return ok;
}

static double apart(const struct ramp *r, const num_dd *x, const num_dd *y)
{
    double most = 0;
    for (int j = 0; j < r->n; j++)
        most = fmax(most, fabs(num_dd_sub(x[j], y[j]).hi) / (r->p->flow->manifold->unit[j] + fabs(y[j].hi)));
    return most;
}

/* A part of the ramp from x, which moves there. table: COLUMNS + 2 rows of n. False, and x as it was: it is too long. */
static bool extrapolate(struct ramp *r, num_dd *x, double part, num_dd *table)
{
    size_t n = (size_t)r->n;
    num_dd *work = table + COLUMNS * n, *best = work + n;
    double last = INFINITY;
    for (int k = 0; k < COLUMNS; k++) {
        num_dd *row = table + (size_t)k * n;
        if (!midpoints(r, x, part, 2 * (k + 1), row, work))
            return false;
        memcpy(best, table, n * sizeof *best);
        for (int i = k - 1; i >= 0; i--) {      /* Aitken and Neville: table[i] becomes the value from rows i to k */
            num_dd ratio = num_dd_of((double)((k + 1) * (k + 1))), by = num_dd_of((double)((i + 1) * (i + 1)));
            num_dd *of = table + (size_t)i * n, *next = of + n;
            for (size_t j = 0; j < n; j++)
                of[j] = num_dd_add(next[j], num_dd_div(num_dd_mul(num_dd_sub(next[j], of[j]), by), num_dd_sub(ratio, by)));
        }
        double change = k ? apart(r, best, table) : INFINITY;
        if (change <= SETTLED || (change <= GOOD && change >= 0.5 * last)) {
            memcpy(x, table, n * sizeof *x);
            return true;
        }
        if (k >= COLUMNS / 2 && change > HOPE)
            return false;
        last = change;
    }
    return false;
}

/* Newton's steps in the kernel, from the end of the ramp to where the constraints that jumped hold. */
static bool polish(struct ramp *r, num_dd *x)
{
    for (int k = 0; k < POLISH; k++) {
        if (!precise_residuals(r->p, r->t, x, 0))
            return false;
        for (int i = 0; i < r->c; i++)
            r->b[i] = r->lost[i].hi != 0 ? num_dd_neg(num_jet2_root(r->p->constraint, i)[0]) : num_dd_of(0);
        if (!direction(r, x))
            return false;
        add(r, x, num_dd_of(1), r->d, x);
    }
    return true;
}

/* What each constraint has lost. */
static bool begin(struct ramp *r, const num_dd *x)
{
    struct manifold *m = r->p->flow->manifold;
    SGA_FREED double *xd = sga_malloc(((size_t)r->n + 1) * sizeof *xd);
    for (int j = 0; j < r->n; j++)
        xd[j] = x[j].hi;
    if (!(manifold_residual(m, r->t.hi, xd, NULL, NULL) >= 0) || !precise_residuals(r->p, r->t, x, 0))
        return false;
    for (int i = 0; i < r->c; i++)
        r->lost[i] = fabs(m->r[i]) <= NO_JUMP ? num_dd_of(0) : num_jet2_root(r->p->constraint, i)[0];
    return true;
}

bool precise_leap(struct precise *p, num_dd t, num_dd *x, const double *found)
{
    const struct leap *l = p->flow->leap;
    if (!l || !p->flow->manifold->c)
        return false;
    size_t n = (size_t)p->n, c = (size_t)p->flow->manifold->c, rows = c + (size_t)l->rows;
    struct ramp r = { .p = p, .t = t, .n = p->n, .c = (int)c, .rows = (int)rows, .kernel = num_jet2_new(l->tape, 0) };
    num_dd *all = sga_calloc(rows * (n + 1) + 2 * c + n * (COLUMNS + 4) + 1, sizeof *all), *at = all + rows * (n + 1) + 2 * c + n, *table = at + n;
    r.a = all;
    r.b = all + rows * (n + 1);
    r.lost = r.b + c;
    r.d = r.lost + c;
    memcpy(at, x, n * sizeof *x);
    bool ok = begin(&r, x);
    double along = 0, part = 1;
    while (ok && along < 1) {
        for (size_t i = 0; i < c; i++)
            r.b[i] = num_dd_neg(r.lost[i]);
        if (extrapolate(&r, at, part, table)) {
            along += part;
            part = fmin(2 * part, 1 - along);
        } else {
            part /= 2;
            ok = part > SHORTEST;
        }
    }
    ok = ok && polish(&r, at);
    for (size_t j = 0; j < n && ok; j++)
        ok = fabs(at[j].hi - found[j]) <= ALIKE * (p->flow->manifold->unit[j] + fabs(found[j]));
    if (ok)
        memcpy(x, at, n * sizeof *x);
    num_jet2_free(r.kernel);
    free(all);
    return ok;
}
