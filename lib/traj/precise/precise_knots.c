/* Motions in double-double from knot to knot of the tables. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "flow.h"
#include "knots.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "precise_series.h"

/* The rest of such a part is no step of its own. */
static const double SLIVER = 1e-3;

num_dd precise_within_knots(const struct precise_march *m, num_dd h)
{
    const struct precise *p = m->p;
    if (!p->knots->tables || m->passed_knots == p->knots->count)
        return h;
    num_dd rest = precise_goal_rest(m), from = m->passed_knots ? p->knot[m->passed_knots - 1] : p->start;
    double left = fabs(rest.hi), whole = fabs(num_dd_sub(p->knot[m->passed_knots], from).hi), most = whole / precise_parts(p);
    double size = fmin(fabs(h.hi), most);
    if (size >= (1 - SLIVER) * left)
        return rest;
    return size < fabs(h.hi) ? num_dd_of(m->direction * size) : h;
}

void precise_knots_begin(struct precise_march *m)
{
    if (m->p->knots->tables)
        knots_enter(m->p->knots, 0);
}

bool precise_pass_knot(struct precise_march *m, double size)
{
    const struct precise *p = m->p;
    if (m->passed_knots == p->knots->count || num_dd_sub(m->here.t, p->knot[m->passed_knots]).hi != 0)
        return true;
    knots_enter(p->knots, ++m->passed_knots);
    if (!precise_land(m)) {
        precise_end(m, ODE_CONSTRAINT_LOST, "the constraints jump here with a table, and in double-double nothing follows; use \"double\", which has more ways to go on");
        return false;
    }
    if (m->sides.count)
        precise_hold(m);
    if (m->method->begin(m->state, m, size) || precise_begin_without_series(m, size))
        return true;
    precise_end(m, ODE_LEFT_DOMAIN, "the vector field has no value beyond this time");
    return false;
}
