/* Whether it is the motion that blows up, or what its errors have become.
 *
 * Where a motion is stable and what it approaches lies beside states from which it runs away (concentrations near 0, which errors make negative), solutions
 * at tolerances that do not see the difference run away at about the same time, and agree on an end that is none. A solution that is far tighter does so much later, or not
 * at all; at a true one it ends there too. */
#include <math.h>

#include "march.h"

static const double FAR = 1e-3;      /* tighter */
static const double ALREADY = 1e-12; /* tolerances below this leave no room for that */
static const double BEYOND = 0.25;   /* of the way to the end: so far it is followed */
static const double APART = 2;       /* of the error of the time: that is another end; */
static const double AT_LEAST = 0.01; /* and so much of the way */

bool ode_blow_up_confirmed(const struct ode_run *run, struct ode_result *res)
{
    double begin = run->start->t, way = res->end.t - begin, last = run->start->times[run->start->count - 1], to = res->end.t + BEYOND * way;
    struct ode_start start = *run->start;
    struct ode_run far = *run;
    struct ode_result r;
    if (res->end.reason != ODE_BLOW_UP || !(fabs(way) > 0) || fmax(res->rtol, res->atol) <= ALREADY)
        return true;
    to = (to - last) * way > 0 ? last : to;
    start.times = &to;
    start.count = 1;
    far.start = &start;
    far.o.rtol = fmax(FAR * res->rtol, FAR * ALREADY);
    far.o.atol = FAR * res->atol;
    far.accompanied = far.beside = false;
    far.noise = NULL;
    far.level++;
    ode_march(&far, &r);
    double later = (r.end.reason == ODE_NONE ? to - res->end.t : ode_reason_placed(r.end.reason) && r.end.reason != ODE_EVENT ? r.end.t - res->end.t : 0) * (way > 0 ? 1 : -1);
    ode_add_stats(&res->second, &r.stats);
    res->solutions++;
    bool passes = r.end.reason == ODE_NONE && to != last;
    ode_result_free(&r);
    return !(passes || later > fmax(APART * res->end.error, AT_LEAST * fabs(way)));
}
