/* From one value of algebraic variables to another, where a jump of the constraints leaves no point of the set near.
 *
 * s + s^3 = u has one s for each u; s^3 - s = u has up to three, and which one follows a jump of u is told by how u gets
 * there: what the constraints have lost falls evenly to 0, as if the jump were a fast ramp, and the values follow without
 * a jump of their own. Past a fold they cannot: then there is no answer. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "jacobian.h"
#include "manifold.h"
#include "mem.h"
#include "tape.h"

static const double SHORTEST = 1e-5;     /* of the ramp */
static const double NO_JUMP = 1e-6;      /* of a row, in natural units: the surface is met as near as steps come */
static const double BENDS = 0.25;        /* of a part's length, its middle may lie beside the straight line */

/* What is left of the loss at the place `along` (0 to 1), solved for from x; the loss of rows that stay is as it is. */
static bool solve(struct manifold *m, double t, const double *lost, const unsigned char *stays, double along, const unsigned char *held, const double *from, double *x)
{
    memcpy(x, from, (size_t)m->n * sizeof *x);
    for (int i = 0; i < m->c; i++)
        m->target[i] = (stays[i] ? 1 : 1 - along) * lost[i];
    return manifold_project(m, t, x, NULL, held, 20, NULL, NULL, NULL);
}

/* Whether x to y is a small part of a smooth way: its middle lies in its middle. */
static bool smooth(const struct manifold *m, const double *x, const double *middle, const double *y)
{
    double length = 0, off = 0;
    for (int j = 0; j < m->n; j++) {
        length = fmax(length, fabs(y[j] - x[j]) / m->unit[j]);
        off = fmax(off, fabs(middle[j] - (x[j] + y[j]) / 2) / m->unit[j]);
    }
    return off <= BENDS * length || length < 1e-12;
}

/* Rows of held variables alone, and what they have lost is no jump: nothing here can take it up, and a projection of all variables does. */
static unsigned char *staying(struct manifold *m, double t, const double *x, const unsigned char *held)
{
    unsigned char *stays = sga_calloc((size_t)m->c + 1, 1);
    if (!(manifold_residual(m, t, x, NULL, NULL) >= 0))
        return stays;
    for (int i = 0; i < m->c; i++) {
        stays[i] = fabs(m->r[i]) <= NO_JUMP;
        for (int k = 0; k < m->cols[i]; k++)
            stays[i] &= held[m->col[i][k]] || m->value[m->jac->start[i] + k] == 0;
    }
    return stays;
}

bool manifold_jump(struct manifold *m, double t, double *x, const unsigned char *held)
{
    size_t n = (size_t)m->n, c = (size_t)m->c;
    double *lost = sga_malloc((c + 1) * sizeof *lost), *y = sga_malloc((3 * n + 1) * sizeof *y), *middle = y + n, *at = middle + n;
    double along = 0, part = 0.25;
    assert(!m->target);       /* it would be forgotten */
    memcpy(m->in, x, n * sizeof *x);
    m->in[n] = t;
    bool ok = num_tape_eval(m->tape, m->in, lost);
    unsigned char *stays = staying(m, t, x, held);
    m->target = sga_calloc(c + 1, sizeof *m->target);
    memcpy(at, x, n * sizeof *x);
    while (ok && along < 1) {
        double to = fmin(1, along + part);
        if (solve(m, t, lost, stays, to, held, at, y) && solve(m, t, lost, stays, (along + to) / 2, held, at, middle) && smooth(m, at, middle, y)) {
            memcpy(at, y, n * sizeof *y);
            along = to;
            part *= 2;
        } else {
            part /= 2;
            ok = part > SHORTEST;
        }
    }
    free(stays);
    free(m->target);
    m->target = NULL;
    if (ok)
        memcpy(x, at, n * sizeof *x);
    free(lost);
    free(y);
    return ok;
}
