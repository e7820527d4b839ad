/* Where the time of a motion ends: budgets of its solutions, and what is said of them. */
#include "rows_kept.h"

#include <math.h>

#include "budget.h"
#include "error.h"
#include "trajectory.h"

const char rows_shortfall[] = "the time granted ended before a tighter solution was found";

/* As lib/ode/global.c's. */
static const double FIRST_PART = 0.45;

bool rows_are_kept(const struct traj_request *rq)
{
    return rq->rows_until > 0 && rq->budget && rq->budget->deadline > 0;
}

const struct traj_request *rows_request(const struct traj_request *rq, double until, struct traj_request *own, struct sga_budget *budget)
{
    *own = *rq;
    *budget = *rq->budget;
    budget->deadline = until;
    own->budget = budget;
    return own;
}

double rows_first_until(double until)
{
    double now = sga_now();
    return now + FIRST_PART * fmax(until - now, 0);
}

bool rows_time_ended(const struct traj_request *rq)
{
    struct sga_error why = { 0 };
    return !sga_budget_ok(rq->budget, &why) && why.code == SGA_E_LIMIT_SECONDS;
}

bool rows_may_end(const struct traj_request *rq, struct sga_error *err)
{
    return (rows_are_kept(rq) && rows_time_ended(rq)) || sga_budget_ok(rq->budget, err);
}

bool rows_beyond_start(const struct traj_request *rq, int rows, struct sga_error *err)
{
    if (rows > 0 && fabs(rq->times[rows - 1] - rq->start) > 0)
        return true;
    if (!err)
        return false;
    double left = fmax(rq->budget->deadline - sga_now(), 0);
    return sga_fail(err, SGA_E_LIMIT_SECONDS, "the limit of %g seconds is too short: %.4g had passed before a solution came to its second sample, and no other would fit beside it; "
                    "raise limits.seconds or ask for samples nearer to the start", rq->budget->seconds, rq->budget->seconds - left);
}
