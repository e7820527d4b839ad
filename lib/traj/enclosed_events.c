/* Events of motions in balls: functions and their rates. */
#include "enclosed.h"

#include <assert.h>

#include "derive.h"
#include "signal.h"
#include "trajectory.h"

/* d_t e + sum_j d_j e X_j. */
static expr_id rate_of(struct expr_store *st, const struct enclose_problem *p, expr_id e)
{
    expr_id rate = expr_time_partial(st, e, p->time);
    for (int j = 0; j < p->n; j++)
        rate = expr_add(st, rate, expr_mul(st, expr_diff(st, e, p->variable[j]), p->field[j]));
    return rate;
}

void enclosed_watch(struct expr_store *st, const struct enclose_problem *problem, const struct traj_request *rq, struct enclose_watch *watch)
{
    assert(problem->n > 0);
    for (int k = 0; k < rq->events; k++) {
        const struct traj_event *e = rq->event + k;
        watch[k] = (struct enclose_watch){ e->expression, rate_of(st, problem, e->expression), e->direction, e->stop, e->most, e->from_zero };
    }
}
