/* Keeping steps on the set: what an integrator asks after every step, from points that are
 * near already. One Jacobian, the normal equations of the least-norm step by Cholesky, and
 * that factor kept for the steps after (chords), which only need the constraints' values.
 * Whatever does not converge so is left to manifold_project, which is careful and slower. */
#include "manifold.h"

#include <math.h>

#include "mem.h"

enum { CHORDS = 4 };
/* A pivot that elimination has made this much smaller: the rows are too near to dependent
 * for normal equations. */
#define DEPENDENT 1e-10
#define ROUNDING 8e-16

/* Scaled rows into m->chord.row (c x n, compact by the pattern), and the residual that each
 * constraint may keep. */
static void scale_rows(struct manifold *m, const double *x, const double *scale)
{
    double size = 1e-3;
    for (int j = 0; j < m->n; j++) {
        double s = fabs(x[j]) / scale[j];
        size = s > size ? s : size;
    }
    for (int i = 0; i < m->c; i++) {
        double big = 0;
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1]; k++) {
            double v = m->value[k] * scale[m->jac->col[k]], a = fabs(v);
            m->value[k] = v;
            big = a > big ? a : big;
        }
        m->chord.most[i] = ROUNDING * size * big;
        m->chord.part[i] = big > 0 ? 1 / big : 0;
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1]; k++)
            m->value[k] *= m->chord.part[i];
    }
}

/* The factor L of J J^T, J the scaled rows. False: they are (nearly) dependent. */
static bool factor(struct manifold *m)
{
    int c = m->c;
    double *L = m->chord.factor, *wide = m->d;
    for (int i = 0; i < c; i++) {
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1]; k++)
            wide[m->jac->col[k]] = m->value[k];
        for (int q = i; q < c; q++) {
            double s = 0;
            for (int k = m->jac->start[q]; k < m->jac->start[q + 1]; k++)
                s += m->value[k] * wide[m->jac->col[k]];
            L[q * c + i] = s;
        }
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1]; k++)
            wide[m->jac->col[k]] = 0;
    }
    for (int i = 0; i < c; i++) {
        double pivot = L[i * c + i], before = pivot;
        for (int k = 0; k < i; k++)
            pivot -= L[i * c + k] * L[i * c + k];
        if (!(pivot > DEPENDENT * before) || !isfinite(pivot))
            return false;
        pivot = 1 / sqrt(pivot);
        L[i * c + i] = pivot;     /* its inverse */
        for (int q = i + 1; q < c; q++) {
            double s = L[q * c + i];
            for (int k = 0; k < i; k++)
                s -= L[q * c + k] * L[i * c + k];
            L[q * c + i] = s * pivot;
        }
    }
    return true;
}

/* x += the least-norm step of the factored rows; m->r holds the constraints. */
static void step(struct manifold *m, double *x, const double *scale)
{
    int c = m->c;
    const double *L = m->chord.factor;
    double *y = m->chord.y;
    for (int i = 0; i < c; i++) {
        double s = -m->r[i] * m->chord.part[i];
        for (int k = 0; k < i; k++)
            s -= L[i * c + k] * y[k];
        y[i] = s * L[i * c + i];
    }
    for (int i = c - 1; i >= 0; i--) {
        double s = y[i];
        for (int k = i + 1; k < c; k++)
            s -= L[k * c + i] * y[k];
        y[i] = s * L[i * c + i];
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

bool manifold_chord(struct manifold *m, double t, double *x, const double *scale)
{
    if (!m->chord.factor)
        return false;
    sga_copy(m->in, x, m->n);
    m->in[m->n] = t;
    if (!num_jacobian_eval(m->jac, m->in, m->r, m->value))
        return false;
    scale_rows(m, x, scale);
    if (within(m))
        return true;
    if (!factor(m))
        return false;
    for (int k = 0; k < CHORDS; k++) {
        step(m, x, scale);
        if (!num_tape_eval_field(m->tape, x, t, m->c, m->r, m->r))
            return false;
        if (within(m))
            return true;
    }
    return false;
}
