/* Keeping steps on the set: what an integrator asks after every step, from points that are
 * near already. One Jacobian, the normal equations of the least-norm step by Cholesky, and
 * that factor kept for the steps after (chords), which only need the constraints' values.
 * Whatever does not converge so is left to manifold_project, which is careful and slower. */
#include "manifold.h"

#include <math.h>

#include "jacobian.h"
#include "larger.h"
#include "mem.h"
#include "tape.h"

enum { CHORDS = 4 };
/* A pivot that elimination has made this much smaller: the rows are too near to dependent
 * for normal equations. */
#define DEPENDENT 1e-10
#define FEW 8.0                /* roundings of a constraint's own terms */
#define DRIFT 0.25             /* of the error allowed, root mean square: what is corrected of what may be roundings; steps put up with so much of these */

/* The largest |x_j| / scale_j; one division, whatever n is. */
static double size_of(const double *x, const double *scale, int n)
{
    double top = 0, under = 1;
    for (int j = 0; j < n; j++)
        if (fabs(x[j]) * under > top * scale[j]) {
            top = fabs(x[j]);
            under = scale[j];
        }
    top /= under;
    return top > 1e-3 ? top : 1e-3;
}

/* Rows in units of scale, compact by the pattern, in m->value; and the residual that each constraint may keep. */
static void scale_rows(struct manifold *m, const double *x, const double *scale)
{
    double size = size_of(x, scale, m->n);
    for (int i = 0; i < m->c; i++) {
        double big = 0, own = 0;
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1] && size > 1; k++)
            own = sga_larger(own, fabs(m->value[k] * x[m->jac->col[k]]));
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1]; k++) {
            double v = m->value[k] * scale[m->jac->col[k]], a = fabs(v);
            m->value[k] = v;
            big = a > big ? a : big;
        }
        m->chord.least[i] = size > 1 ? MANIFOLD_ROUNDING * fmin(size * big, FEW * fmax(own, 1e-3 * big)) : MANIFOLD_ROUNDING * size * big;
        m->chord.most[i] = MANIFOLD_ROUNDING * (size > 1 ? fmin(size * big, MANIFOLD_OWN * fmax(own, 1e-3 * big)) : size * big);
    }
}

/* J J^T = L D L^T, J the scaled rows; in place of the diagonal 1 / D. False: they are (nearly) dependent. */
static bool factor(struct manifold *m)
{
    int c = m->c;
    const int *start = m->jac->start, *col = m->jac->col;
    double *L = m->chord.factor, *wide = m->d;
    for (int j = 0; c > 1 && j < m->n; j++)
        wide[j] = 0;      /* others use it too */
    for (int i = 0; i < c; i++) {
        double s = 0;
        for (int k = start[i]; k < start[i + 1]; k++)
            s += m->value[k] * m->value[k];
        L[i * c + i] = s;
        if (i == c - 1)
            break;
        for (int k = start[i]; k < start[i + 1]; k++)
            wide[col[k]] = m->value[k];
        for (int q = i + 1; q < c; q++) {
            s = 0;
            for (int k = start[q]; k < start[q + 1]; k++)
                s += m->value[k] * wide[col[k]];
            L[q * c + i] = s;
        }
        for (int k = start[i]; k < start[i + 1]; k++)
            wide[col[k]] = 0;
    }
    for (int i = 0; i < c; i++) {
        double *row = L + i * c, pivot = row[i], before = pivot;
        for (int k = 0; k < i; k++) {        /* row[k] is L_ik D_k so far */
            double s = row[k];
            for (int q = 0; q < k; q++)
                s -= row[q] * L[k * c + q];
            row[k] = s;
        }
        for (int k = 0; k < i; k++) {
            double s = row[k] * L[k * c + k];
            pivot -= row[k] * s;
            row[k] = s;
        }
        if (!(pivot > DEPENDENT * before) || !isfinite(pivot))
            return false;
        row[i] = 1 / pivot;
    }
    return true;
}

/* x += the least-norm step of the factored rows; m->r holds the constraints. The sums of these and of the multipliers
 * over the steps are kept. */
static void step(struct manifold *m, double *x, const double *scale)
{
    int c = m->c;
    const double *L = m->chord.factor;
    double *y = m->chord.y;
    for (int i = 0; i < c; i++) {
        double s = -m->r[i];
        for (int k = 0; k < i; k++)
            s -= L[i * c + k] * y[k];
        y[i] = s;
        m->chord.sum_r[i] -= m->r[i];
    }
    for (int i = c - 1; i >= 0; i--) {
        double s = y[i] * L[i * c + i];
        for (int k = i + 1; k < c; k++)
            s -= L[k * c + i] * y[k];
        y[i] = s;
        m->chord.sum_y[i] += s;
    }
    for (int i = 0; i < c; i++)
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1]; k++)
            x[m->jac->col[k]] += y[i] * m->value[k] * scale[m->jac->col[k]];
}

static bool within(struct manifold *m)
{
    bool all = true;
    m->raw = 0;
    for (int i = 0; i < m->c; i++) {
        double a = fabs(m->r[i]);
        m->raw = a > m->raw ? a : m->raw;
        all &= a <= m->chord.most[i];
    }
    return all;
}

/* What the constraints are off is a few roundings: where tolerances are tight, more of them would grow from step to step, until it is more than
 * all that roundings may be. */
static bool few(const struct manifold *m)
{
    bool all = true;
    for (int i = 0; i < m->c; i++)
        all &= fabs(m->r[i]) <= m->chord.least[i];
    return all;
}

/* |J^T y|^2 = y^T (J J^T y), y the sum of all multipliers, J J^T y that of all constraints. */
static double way(const struct manifold *m)
{
    double s = 0;
    for (int i = 0; i < m->c; i++)
        s += m->chord.sum_y[i] * m->chord.sum_r[i];
    return s > 0 ? sqrt(s) : 0;
}

static bool by_chords(struct manifold *m, double t, double *x, const double *scale, double *moved)
{
    *moved = 0;
    if (!num_jacobian_eval(m->jac, m->in, m->r, m->value))
        return false;
    scale_rows(m, x, scale);
    bool on = within(m);
    if (on && few(m))
        return true;
    if (!factor(m))
        return on;
    for (int i = 0; i < m->c; i++)
        m->chord.sum_y[i] = m->chord.sum_r[i] = 0;
    for (int k = 0; k < CHORDS; k++) {
        step(m, x, scale);
        if (!num_tape_eval_field(m->tape, x, t, m->c, m->r, m->r))
            return false;
        if (within(m)) {
            *moved = way(m);
            if (on && *moved > DRIFT * sqrt(m->n)) {      /* roundings, of rows that nearly depend on each other */
                *moved = 0;
                sga_copy(x, m->in, m->n);
            }
            return true;
        }
        if (on)
            break;
    }
    if (on)
        sga_copy(x, m->in, m->n);
    return on;
}

bool manifold_chord(struct manifold *m, double t, double *x, const double *scale, double *moved)
{
    if (!m->chord.factor)
        return false;
    sga_copy(m->in, x, m->n);
    m->in[m->n] = t;
    if (by_chords(m, t, x, scale, moved))
        return true;
    sga_copy(x, m->in, m->n);
    return false;
}
