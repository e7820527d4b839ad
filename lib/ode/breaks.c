/* Breaks of the problem: what changes where a step ends at one. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "march.h"
#include "mem.h"

double ode_goal(const struct ode_march *m)
{
    return m->next_break < m->p->break_count ? m->p->breaks[m->next_break] : m->stop;
}

void ode_enter(struct ode_march *m)
{
    double goal = ode_goal(m);
    assert((goal - m->t) * m->direction >= 0);       /* breaks are given in the order of the motion */
    m->piece = m->p->break_count ? fabs(goal - m->t) : INFINITY;
    if (m->choice.series_state)
        ode_taylor.forget(m->choice.series_state);       /* another piece has another series */
    if (m->p->enter)
        m->p->enter(m->p->ctx, m->t, goal);
}

/* At a break beyond which the constraints may be others: what may jump does. False: it cannot. Where switches are held nothing jumps here. */
static bool land(struct ode_march *m)
{
    const struct ode_problem *p = m->p;
    double residual, *old;
    if (!p->jump || !p->project || m->kinks)
        return true;
    old = sga_malloc(((size_t)p->n + 1) * sizeof *old);
    sga_copy(old, m->x, p->n);
    bool ok = ode_settle(m, m->t, m->x, 1, &residual);
    if (!ok) {
        sga_copy(m->x, old, p->n);
        ok = p->jump(p->ctx, m->t, m->x);
        for (int j = 0; j < p->n; j++)
            m->carry[j] = m->x[j] == old[j] ? m->carry[j] : 0;
    }
    free(old);
    return ok;
}

bool ode_pass_break(struct ode_march *m)
{
    if (m->next_break == m->p->break_count || m->t != m->p->breaks[m->next_break])
        return true;
    m->next_break++;
    assert(ode_march_sane(m));
    ode_enter(m);
    if (!land(m)) {
        ode_end_at(m, ODE_CONSTRAINT_LOST, "the constraints jump here with a table, and what no equation differentiates cannot follow");
        return false;
    }
    if (!ode_kinks_enter(m))
        return false;
    if (ode_eval(&m->field, m->t, m->x, m->f)) {
        ode_kinks_look(m);
        return true;
    }
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}
