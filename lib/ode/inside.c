/* Samples inside steps. Their polynomials miss the motion by what steps of this size do, and where both of the solutions that are compared made the same
 * step, or lie in theirs alike, their difference does not show it: it is added. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "march.h"
#include "tolerance.h"

/* All variables are off to one side, and each to the other side of its neighbours. */
enum { PATTERNS = 2 };

void ode_inside(const struct ode_run *run, const struct ode_result *r, int k, const double *y, double *e)
{
    const struct ode_problem *p = run->p;
    const struct sga_tolerance used = { r->rtol, r->atol };
    const double *x = r->samples + (size_t)k * (size_t)r->n;
    int columns = p->output ? p->outputs : r->n;
    assert(r->inside[k] >= 0 && r->atol >= 0);
    for (int c = 0; c < columns; c++)
        e[c] = r->inside[k] * sga_allowed(used, !p->output ? run->unit[c] : run->o.output_unit ? run->o.output_unit[c] : 1, y[c]);
    if (!p->output || !(r->inside[k] > 0))
        return;
    SGA_FREED double *off = sga_malloc(((size_t)r->n + (size_t)columns + 1) * sizeof *off);
    double *other = off + r->n;
    for (int turn = 0; turn < PATTERNS; turn++) {
        for (int j = 0; j < r->n; j++)
            off[j] = x[j] + (turn && j % 2 ? -1 : 1) * r->inside[k] * sga_allowed(used, run->unit[j], x[j]);
        p->output(p->ctx, run->start->times[k], off, other);
        for (int c = 0; c < columns; c++) {
            double by = fabs(other[c] - y[c]);
            e[c] = isfinite(by) ? (turn ? fmax(e[c], by) : by) : e[c];
        }
    }
}
