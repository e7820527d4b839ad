/* Rows that are kept where time ends: whose budget ends when, and what is said. */
#include "budget.h"
#include "check.h"
#include "error.h"
#include "rows_kept.h"
#include "trajectory.h"

#include <math.h>
#include <string.h>

static bool asked_to_stop(void *ctx)
{
    return ctx != NULL;
}

static void wanted(void)
{
    struct sga_budget none = { 0 }, some = { .deadline = sga_now() + 100 };
    struct traj_request rq = { .budget = &some, .rows_until = sga_now() + 50 };
    CHECK(rows_are_kept(&rq));
    rq.rows_until = 0;
    CHECK(!rows_are_kept(&rq));
    rq.rows_until = sga_now() + 50;
    rq.budget = &none;
    CHECK(!rows_are_kept(&rq), "nothing ends");
    rq.budget = NULL;
    CHECK(!rows_are_kept(&rq));
}

/* Another deadline, and all else as it was. */
static void shorter(void)
{
    struct sga_budget budget = { .deadline = sga_now() + 100, .seconds = 7, .max_nodes = 5 }, own_budget;
    struct traj_request rq = { .budget = &budget, .samples = 3, .rtol = 1e-5 }, own;
    const struct traj_request *q = rows_request(&rq, 12.5, &own, &own_budget);
    CHECK(q == &own && q->budget == &own_budget && q->samples == 3 && q->rtol == 1e-5);
    CHECK(q->budget->deadline == 12.5 && q->budget->seconds == 7 && q->budget->max_nodes == 5);
    CHECK(rq.budget == &budget && budget.deadline > 12.5, "the request itself is not changed");
    double now = sga_now(), first = rows_first_until(now + 1000), late = rows_first_until(now - 10), after = sga_now();
    CHECK(first > now + 100 && first < after + 500, "the second solution, which is tighter, has more: %g", first - now);
    CHECK(late >= now && late <= after, "no time is left: %g", late - now);
}

/* The time is over, and nothing else is. */
static void ended(void)
{
    struct sga_budget budget = { .deadline = sga_now() + 100, .cancelled = asked_to_stop };
    struct traj_request rq = { .budget = &budget };
    CHECK(!rows_time_ended(&rq));
    budget.cancel_ctx = &budget;
    CHECK(!rows_time_ended(&rq), "a cancellation");
    budget.cancel_ctx = NULL;
    budget.deadline = sga_now() - 1;
    CHECK(rows_time_ended(&rq));
}

static void beyond(void)
{
    const double times[] = { 1, 1.5, 2 }, back[] = { 1, 0.5 };
    struct sga_budget budget = { .deadline = sga_now() + 6, .seconds = 8 };
    struct traj_request rq = { .start = 1, .times = times, .samples = 3, .budget = &budget };
    struct sga_error err = { 0 };
    CHECK(!rows_beyond_start(&rq, 0, NULL) && !rows_beyond_start(&rq, 1, NULL), "the start alone");
    CHECK(rows_beyond_start(&rq, 2, &err) && rows_beyond_start(&rq, 3, &err) && err.code == SGA_E_OK);
    double before = 8 - (budget.deadline - sga_now()), passed = 0;
    CHECK(!rows_beyond_start(&rq, 1, &err) && err.code == SGA_E_LIMIT_SECONDS && strstr(err.detail, "8 seconds"), "%s", err.detail);
    double after = 8 - (budget.deadline - sga_now());
    const char *said = strstr(err.detail, "short: ");
    CHECK(said && sscanf(said, "short: %lf", &passed) == 1 && passed >= before - 0.01 && passed <= after + 0.01, "%g to %g: %s", before, after, err.detail);
    rq.times = back;
    CHECK(rows_beyond_start(&rq, 2, NULL) && !rows_beyond_start(&rq, 1, NULL), "backwards");
}

int main(void)
{
    wanted();
    shorter();
    ended();
    beyond();
    return CHECK_END();
}
