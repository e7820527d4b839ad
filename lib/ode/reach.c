/* May a march go on? Within the time granted and the steps allowed, and with hope to arrive. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "budget.h"
#include "error.h"
#include "march.h"
#include "share.h"

#define LOOK_EVERY 5000        /* attempts between looks at whether the stop is in reach */
#define BUDGET_EVERY 8         /* attempts between looks at the clock, */
#define BUDGET_TIME 0.02       /* where they take no longer than this (seconds) */
#define BEYOND_HOPE 5.0        /* times the limit of steps */
#define ACROSS_LOOKS 5
#define PILE_EVERY 1000        /* attempts; */
#define PILED 1e-6             /* where they went no further than this part of the time passed, they pile up */

/* At the present pace, would the stop take far more steps than are allowed, again and
 * again, without the pace picking up? */
static bool out_of_reach(struct ode_march *m)
{
    double progress = fabs(m->t - m->look_t);
    double needed = fabs(m->stop - m->t) / fmax(progress, 1e-300) * LOOK_EVERY;
    assert(ode_march_sane(m));
    bool slow = needed > BEYOND_HOPE * (double)m->o->max_steps &&
                progress <= 1.2 * m->look_progress;
    m->hopeless = slow ? m->hopeless + 1 : 0;
    if (m->hopeless == 1)
        m->slow_since = m->look_t;
    m->look_progress = progress;
    m->look_t = m->t;
    m->look_at += LOOK_EVERY;
    return m->hopeless >= ACROSS_LOOKS;
}

/* Beside a singularity that is seen as far as the tolerances go, steps pile up, each time less further, while something grows. */
static bool piles_up(struct ode_march *m)
{
    bool piled = fabs(m->t - m->pile_t) <= PILED * fabs(m->t - m->start->t) && ode_grows(m);
    if (piled) {
        m->hopeless++;
        m->slow_since = m->pile_t;
    }
    m->pile_t = m->t;
    m->pile_at += PILE_EVERY;
    return piled;
}

bool ode_within_budget(struct ode_march *m)
{
    struct sga_error err = {0};     /* large: not for every attempt */
    if (sga_budget_ok(m->o->budget, &err))
        return true;
    ode_end_at(m, err.code == SGA_E_CANCELLED ? ODE_CANCELLED : ODE_TIME_LIMIT, err.detail);
    return false;
}

/* Of time, in this solution; the ones that are compared with it each take half of what is left: how many there will be is not known. */
static void tell_share(const struct ode_march *m)
{
    bool several = m->o->estimate_global_error, alone = m->companion && m->level == 1;       /* perhaps the only one: no looser one comes before it */
    double way = fabs(m->stop - m->start->t), before = several && !alone ? 1 - ldexp(1, -m->level) : 0, part = !several ? 1 : alone ? 0.75 : 0.5 * (1 - before);
    if (way > 0)
        sga_share_tell(m->o->budget, before + part * fabs(m->t - m->start->t) / way, m->t);
}

bool ode_may_go_on(struct ode_march *m)
{
    long attempts = m->res->stats.steps + m->res->stats.refused;
    if (attempts >= m->budget_at) {
        if (!ode_within_budget(m))
            return false;
        double now = sga_now();
        m->budget_at = attempts + (now - m->budget_looked < BUDGET_TIME ? BUDGET_EVERY : 1);
        m->budget_looked = now;
        tell_share(m);
    }
    if (attempts >= m->o->max_steps) {
        ode_end_steps(m, false);
        return false;
    }
    if ((attempts >= m->pile_at + PILE_EVERY && piles_up(m)) || (attempts >= m->look_at + LOOK_EVERY && out_of_reach(m))) {
        ode_end_steps(m, true);
        return false;
    }
    return true;
}
