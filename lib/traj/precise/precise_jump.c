/* What jumps as switches turn or tables go on, in double-double: constraints that are others, and other switches with them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "flow.h"
#include "jet.h"
#include "manifold.h"
#include "mem.h"
#include "precise_leap.h"
#include "precise_march.h"
#include "precise_series.h"

/* What double found (n), by all digits: what does not jump is exact, and the rest is solved for. */
static bool land_by_parts(struct precise_march *m, const num_dd *old, const double *found)
{
    struct flow *f = m->p->flow;
    double moved, residual;
    for (int j = 0; j < m->n; j++)
        if (f->moving[j] && found[j] != old[j].hi)       /* sums of variables are held */
            return false;
    for (int j = 0; j < m->n; j++)
        m->here.x[j] = f->moving[j] ? old[j] : num_dd_of(found[j]);
    precise_project(m->p, m->here.t, m->here.x, m->scale, f->moving, &moved, &residual);      /* what rests may still be off its rows by what turning beside the surface does: settling moves all, by little */
    return precise_settle(m, &m->here);
}

static bool land_by_sums(struct precise_march *m, const num_dd *old, const double *found)
{
    memcpy(m->here.x, old, (size_t)m->n * sizeof *old);
    return precise_leap(m->p, m->here.t, m->here.x, found) && precise_settle(m, &m->here);
}

bool precise_land(struct precise_march *m)
{
    struct flow *f = m->p->flow;
    size_t n = (size_t)m->n;
    SGA_FREED num_dd *old = memcpy(sga_malloc((n + 1) * sizeof *old), m->here.x, n * sizeof *old);
    SGA_FREED double *x = sga_malloc((n + 1) * sizeof *x);
    if (precise_settle(m, &m->here))
        return true;
    enum ode_reason why = m->why;
    for (size_t j = 0; j < n; j++)
        x[j] = old[j].hi;
    if (f->manifold->c && flow_jump(f, m->here.t.hi, x) && (land_by_parts(m, old, x) || land_by_sums(m, old, x)))
        return true;
    memcpy(m->here.x, old, n * sizeof *old);
    for (size_t j = 0; j < n; j++)
        x[j] = old[j].hi;
    bool valued = f->manifold->c && manifold_residual(f->manifold, m->here.t.hi, x, NULL, NULL) >= 0;      /* they have values, and none of the points is near */
    bool singular = !precise_allowed(m, &m->here) && m->why == ODE_SINGULAR;
    m->why = singular ? ODE_SINGULAR : valued ? ODE_CONSTRAINT_LOST : why;
    return false;
}

bool precise_arguments(struct precise_march *m, num_dd t, const num_dd *x, num_dd *g, size_t step)
{
    struct precise_sides *q = &m->sides;
    num_jet2_hold(q->surface, m->p->flow->surface);
    for (int j = 0; j < m->n; j++)
        num_jet2_input(q->surface, j)[0] = x[j];
    num_jet2_input(q->surface, m->n)[0] = t;
    bool ok = num_jet2_next(q->surface, 0);
    for (int e = 0; e < q->count; e++)
        g[(size_t)e * step] = num_jet2_root(q->surface, e)[0];
    return ok;
}

void precise_note_arguments(struct precise_march *m)
{
    if (!precise_arguments(m, m->here.t, m->here.x, m->sides.argument, 1))
        for (int e = 0; e < m->sides.count; e++)
            m->sides.argument[e] = num_dd_of(NAN);
}

bool precise_leaps(const struct precise_sides *q, int e, num_dd was)
{
    double now = q->argument[e].hi;
    return fabs(now) > q->doubt[e] && fabs(num_dd_sub(q->argument[e], was).hi) > 0.5 * fabs(now);
}

void precise_doubt_both(struct precise_march *m, const struct expansion *near)
{
    struct precise_sides *q = &m->sides;
    SGA_FREED double *before = memcpy(sga_malloc(((size_t)q->count + 1) * sizeof *before), q->doubt, (size_t)q->count * sizeof *before);
    precise_grains(m, &m->here, near);
    for (int e = 0; e < q->count; e++)
        q->doubt[e] = fmax(q->doubt[e], before[e]);
}

int precise_turn_leapt(struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    int turned = 0;
    SGA_FREED num_dd *was = memcpy(sga_malloc(((size_t)q->count + 1) * sizeof *was), q->argument, (size_t)q->count * sizeof *was);
    precise_note_arguments(m);
    for (int e = 0; e < q->count; e++)
        if (precise_leaps(q, e, was[e]) && q->side[e] * q->argument[e].hi < 0) {
            q->side[e] = (signed char)-q->side[e];
            turned++;
        }
    if (turned)
        precise_hold(m);
    return turned;
}

bool precise_carry(struct precise_march *m, const struct expansion *near)
{
    precise_hold(m);
    for (int round = 0; round <= precise_rounds(m); round++) {
        bool landed = precise_land(m);
        precise_doubt_both(m, near);
        if (!precise_turn_leapt(m))
            return landed;
    }
    m->why = ODE_NOT_SMOOTH;
    return false;
}
