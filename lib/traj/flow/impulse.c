/* See impulse.h. */
#include "impulse.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "field.h"
#include "jacobian.h"
#include "leap.h"
#include "manifold.h"
#include "mem.h"
#include "tape.h"

static const double SOON = 1e-4;      /* of the time passed: a switch turns there */
static const double SMALL = 1e-6;     /* of a row, in natural units: no jump */
static const double NOTHING = 1e-9;   /* of the largest entry of a row, in natural units */

/* Values of the switches' arguments at (t, x). */
static void arguments(struct flow *f, double t, const double *x, double *g)
{
    memcpy(f->in, x, (size_t)f->n * sizeof *x);
    f->in[f->n] = t;
    num_tape_eval(f->surface, f->in, g);
}

/* side[k]: where switch k is at home, turns[k]: it turns there; returns how long it is to the first, or INFINITY. */
static double turning(struct flow *f, const double *v, double passed, signed char *side, unsigned char *turns)
{
    int count = f->field->switches->count, n = f->n;
    double *g = sga_malloc((2 * (size_t)count + (size_t)n + 1) * sizeof *g), *later = g + count, *x = later + count, first = INFINITY;
    double t = f->field->home_t, h = SOON * passed;
    for (int j = 0; j < n; j++)
        x[j] = f->field->home[j] + h * v[j];
    arguments(f, t, f->field->home, g);
    arguments(f, t + h, x, later);
    for (int k = 0; k < count; k++) {
        double left = -g[k] / ((later[k] - g[k]) / h);
        side[k] = g[k] > 0 ? 1 : g[k] < 0 ? -1 : later[k] > 0 ? -1 : 1;
        turns[k] = fabs(left) <= fabs(h) && isfinite(left);
        if (turns[k] && fabs(left) < fabs(first))
            first = left;
    }
    free(g);
    return first;
}

/* Whether no combination of the columns is the last one: rows x (columns + 1), which are used up. */
static bool outside(double *a, int rows, int columns)
{
    int wide = columns + 1, rank = 0;
    for (int j = 0; j < columns && rank < rows; j++) {
        int best = rank;
        for (int i = rank; i < rows; i++)
            best = fabs(a[i * wide + j]) > fabs(a[best * wide + j]) ? i : best;
        if (!(fabs(a[best * wide + j]) > NOTHING))
            continue;
        for (int k = 0; k < wide; k++) {
            double v = a[best * wide + k];
            a[best * wide + k] = a[rank * wide + k];
            a[rank * wide + k] = v;
        }
        for (int i = rank + 1; i < rows; i++) {
            double q = a[i * wide + j] / a[rank * wide + j];
            for (int k = j; k < wide && q != 0; k++)
                a[i * wide + k] -= q * a[rank * wide + k];
        }
        rank++;
    }
    double most = 0;
    for (int i = rank; i < rows; i++)
        most = fmax(most, fabs(a[i * wide + columns]));
    return most > SMALL;
}

/* The constraints' jump (c) in units of their largest slopes; m->value holds their derivatives, m->slope these. */
static bool jumps(struct flow *f, double t, const signed char *before, const signed char *after, double *jump)
{
    struct manifold *m = f->manifold;
    double *r = sga_malloc(((size_t)m->c + 1) * sizeof *r);
    memcpy(m->in, f->field->home, (size_t)f->n * sizeof *m->in);
    m->in[f->n] = t;
    flow_hold(f, before);
    bool ok = num_tape_eval(m->tape, m->in, r);
    flow_hold(f, after);
    ok = ok && num_jacobian_eval(m->jac, m->in, jump, m->value);
    flow_hold(f, NULL);
    for (int i = 0; i < m->c && ok; i++)
        jump[i] -= r[i];
    free(r);
    return ok;
}

/* Where equations differentiate sums of variables: these, as rows of n + 1, do not jump. */
static bool sums_hold(struct flow *f, double *row)
{
    size_t n = (size_t)f->n;
    if (!f->leap)
        return true;
    double *A = sga_malloc(((size_t)f->leap->rows * n + 1) * sizeof *A);
    bool ok = leap_rows(f, f->field->home_t, f->field->home, A);
    for (size_t i = 0; i < (size_t)f->leap->rows && ok; i++)
        memcpy(row + i * (n + 1), A + i * n, n * sizeof *row);
    free(A);
    return ok;
}

bool impulse_at_end(struct flow *f, double *t, int *constraint, double *jump)
{
    struct manifold *m = f->manifold;
    int count = f->field->switches->count, n = f->n, free_columns = 0, held = f->leap ? f->leap->rows : 0;
    if (!count || !m->c || !f->surface)
        return false;
    size_t wide = (size_t)n + 1;
    double *by = sga_calloc((size_t)m->c + ((size_t)m->c + (size_t)held) * wide + wide + 1, sizeof *by), *a = by + m->c, *v = a + ((size_t)m->c + (size_t)held) * wide;
    signed char *before = sga_calloc(3 * (size_t)count + 1, 1), *after = before + count;
    unsigned char *turns = (unsigned char *)after + count;
    int *at = sga_malloc(wide * sizeof *at);
    bool found = false;
    if (!field_eval(f->field, f->field->home_t, f->field->home, v))      /* on the surface: what turns by time alone is seen still */
        memset(v, 0, (size_t)n * sizeof *v);
    double left = turning(f, v, *t - f->field->begin_t, before, turns);
    for (int k = 0; k < count; k++)
        after[k] = (signed char)(turns[k] ? -before[k] : before[k]);
    if (isfinite(left) && jumps(f, f->field->home_t, before, after, by)) {
        for (int j = 0; j < n; j++)
            at[j] = f->moving[j] && !held ? -1 : free_columns++;
        *jump = 0;
        for (int i = 0; i < m->c; i++) {
            double most = 0, *row = a + (size_t)i * ((size_t)free_columns + 1);
            for (int e = m->jac->start[i]; e < m->jac->start[i + 1]; e++)
                most = fmax(most, fabs(m->value[e]) * m->unit[m->jac->col[e]]);
            most = most > 0 ? most : 1;
            for (int e = m->jac->start[i]; e < m->jac->start[i + 1]; e++)
                if (at[m->jac->col[e]] >= 0)
                    row[at[m->jac->col[e]]] = m->value[e] * m->unit[m->jac->col[e]] / most;
            row[free_columns] = by[i] / most;
            if (fabs(by[i]) / most > SMALL && (!found || fabs(by[i]) > fabs(*jump))) {
                *constraint = i;
                *jump = by[i];
                found = true;
            }
        }
        found = found && sums_hold(f, a + (size_t)m->c * wide) && outside(a, m->c + held, free_columns);
    }
    if (found)
        *t = f->field->home_t + left;
    free(by);
    free(before);
    free(at);
    return found;
}
