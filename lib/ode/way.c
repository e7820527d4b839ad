/* A step as a way: its polynomial between its ends, and at the ends the states there, which were brought back to the constraints. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "march.h"
#include "mem.h"

static void at(void *of, double s, double *g)
{
    struct ode_way *w = of;
    struct ode_march *m = w->m;
    m->method->dense_at(m->state, &m->step, s, w->x);
    w->function(m->p->ctx, m->t + (s * m->step.h + m->t_low), w->x, g);
}

static void end(void *of, bool last, double *g)
{
    struct ode_way *w = of;
    struct ode_march *m = w->m;
    w->function(m->p->ctx, last ? m->t1 : m->t, last ? m->x1 : m->x, g);
}

void ode_way_begin(struct ode_way *w, struct ode_march *m, int count, void (*function)(void *, double, const double *, double *))
{
    *w = (struct ode_way){ .way = { .count = count, .at = at, .end = end, .of = w, .budget = m->o->budget }, .m = m, .function = function };
    w->x = sga_malloc(((size_t)m->p->n + 1) * sizeof *w->x);
}

const struct guard_way *ode_way_ready(struct ode_way *w)
{
    const struct ode_march *m = w->m;
    w->way.grain = 2 * DBL_EPSILON * fmax(fabs(m->t), fabs(m->t1)) / fabs(m->step.h);
    return &w->way;
}

void ode_way_end(struct ode_way *w) { free(w->x); }
