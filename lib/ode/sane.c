/* What holds of a march, its sides and its result whatever is asked for. See doc/developer.md, "Assertions". */
#include <float.h>
#include <math.h>

#include "kink.h"
#include "march.h"

/* b is not before a, but for what two roundings of their size make. */
static bool in_order(double a, double b, double direction)
{
    return (b - a) * direction >= -4 * DBL_EPSILON * (fabs(a) + fabs(b));
}

bool ode_march_sane(const struct ode_march *m)
{
    const struct ode_choice *c = &m->choice;
    const void *state = m->method->implicit ? c->implicit_state : m->method->series ? c->series_state : c->explicit_state;
    bool time = in_order(m->last_times[1], m->t, m->direction) && in_order(m->t, ode_goal(m), m->direction) && fabs(m->t_low) <= DBL_EPSILON * fabs(m->t);
    bool samples = m->next >= 0 && m->next <= m->start->count && m->dense_ratio > 0 && m->dense_ratio <= 1;
    return time && samples && m->state == state;
}

bool ode_kinks_sane(const struct ode_kinks *k)
{
    bool sane = k->target >= -1 && k->target < k->count && k->cut >= 0 && k->limit >= 0 && k->short_h >= 0 && k->scale > 0;
    for (int e = 0; e < k->count && sane; e++)
        sane = k->side[e] >= -1 && k->side[e] <= 1 && k->fresh[e] <= 1;
    return sane;
}

/* Where the march came to the last time there is a sample for each time, and no event lies past the end, or before the one that was before it. */
bool ode_result_sane(const struct ode_start *start, const struct ode_result *r)
{
    double direction = start->times[start->count - 1] < start->t ? -1 : 1;
    bool sane = r->count >= 0 && r->count <= start->count && (r->end.reason != ODE_NONE || r->count == start->count);
    for (int i = 0; i < r->happened && sane; i++)
        sane = in_order(i > 0 ? r->happening[i - 1].t : start->t, r->happening[i].t, direction) && !(r->happening[i].error < 0);
    for (int k = 0; k < r->count && r->error && sane; k++)
        sane = r->error[k] >= 0 && r->error[k] <= r->max_error;
    return sane && (!r->happened || in_order(r->happening[r->happened - 1].t, r->end.t, direction)) &&
           (!r->count || in_order(start->times[r->count - 1], r->end.t, direction));
}
