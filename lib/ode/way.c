/* A step as a way, for what is watched here, and as a path, for what the problem watches itself: its polynomial between its ends, and at the ends the states there, which were
 * brought back to the constraints. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "larger.h"
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

static void place(const void *march, double s, double *x)
{
    const struct ode_march *m = march;
    if (s == 0 || s == 1)
        sga_copy(x, s == 0 ? m->x : m->x1, m->p->n);
    else
        m->method->dense_at(m->state, &m->step, s, x);
}

static bool ready(void *march)
{
    struct ode_march *m = march;
    m->dense_checked = m->dense_checked || m->method->dense_begin(m->state, &m->field, &m->step);
    return m->dense_checked;
}

/* What steps have erred by so far, each in units of what it was allowed, and roundings: a motion that touches the end of a domain again and again goes on. */
static double error_of(const void *march, int j)
{
    const struct ode_march *m = march;
    double allowed = ode_allowed(m->o->rtol, m->o->atol, m->unit[j], m->x[j], m->x1[j]), size = sga_larger(fabs(m->x[j]), fabs(m->x1[j]));
    return ODE_ERRORS * ode_erred(m) * allowed + ODE_TOLD * size;
}

bool ode_goes_on_along(struct ode_march *m)
{
    struct ode_path path = { .march = m, .t = m->t, .h = m->step.h, .at = place, .ready = ready, .error = error_of, .f0 = m->f, .f1 = m->f1, .budget = m->o->budget,
                             .stages = !(m->method->series || m->method->implicit) };
    return m->p->along(m->p->ctx, &path) || ode_eval_refused(&m->field);
}
