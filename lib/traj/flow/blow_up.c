/* See blow_up.h. */
#include "blow_up.h"

#include <math.h>
#include <string.h>

#include "ode.h"
#include "trajectory.h"

static const double FAR = 1e-3;      /* tighter */
static const double ALREADY = 1e-12; /* tolerances below this leave no room for that */
static const double BEYOND = 0.25;   /* of the way to the end: so far it is followed */
static const double APART = 2;       /* of the error of the time: that is another end; */
static const double AT_LEAST = 0.01; /* and so much of the way */

static double tighter(double tolerance) { return fmax(FAR * tolerance, fmin(tolerance, FAR * ALREADY)); }

void blow_up_confirm(const struct ode_problem *p, const struct ode_start *start, const struct ode_options *options, struct traj_result *r)
{
    double way = r->ended_t - start->t, last = start->times[start->count - 1], to = r->ended_t + BEYOND * way;
    if (strcmp(r->ended_reason, ode_reason_text(ODE_BLOW_UP)) != 0 || !(fabs(way) > 0) || fmax(options->rtol, options->atol) <= ALREADY)
        return;
    bool cut = (to - last) * way > 0;
    to = cut ? last : to;
    struct ode_start far = *start;
    struct ode_options o = *options;
    struct ode_result s;
    far.times = &to;
    far.count = 1;
    o.rtol = tighter(o.rtol);
    o.atol = tighter(o.atol);
    o.estimate_global_error = o.refine = o.keep_rows = false;
    if (!ode_solve(p, &far, &o, &s, NULL))
        return;
    bool passes = s.end.reason == ODE_NONE, ends = ode_reason_placed(s.end.reason) && s.end.reason != ODE_EVENT;
    double later = ((passes ? to : s.end.t) - r->ended_t) * (way > 0 ? 1 : -1);
    r->steps += s.stats.steps;
    r->rejected += s.stats.refused;
    r->evaluations += s.stats.evaluations;
    ode_result_free(&s);
    if (!(passes && !cut) && !((passes || ends) && later > fmax(APART * r->ended_error, AT_LEAST * fabs(way))))
        return;
    traj_end_by_errors(r);
}
