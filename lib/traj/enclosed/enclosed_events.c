/* Events of motions in balls: functions and their rates. */
#include "enclosed.h"

#include <assert.h>

#include "derive.h"
#include "signal.h"
#include "trajectory.h"

expr_id enclosed_rate(struct expr_store *st, expr_id e, const int *variable, int n, int time, const expr_id *field)
{
    expr_id rate = expr_time_partial(st, e, time);
    for (int j = 0; j < n; j++)
        rate = expr_add(st, rate, expr_mul(st, expr_diff(st, e, variable[j]), field[j]));
    return rate;
}

void enclosed_watch(struct expr_store *st, const struct enclose_problem *problem, const struct traj_request *rq, struct enclose_watch *watch)
{
    assert(problem->n > 0);
    for (int k = 0; k < rq->events; k++) {
        const struct traj_event *e = rq->event + k;
        watch[k] = (struct enclose_watch){ e->expression, enclosed_rate(st, e->expression, problem->variable, problem->n, problem->time, problem->field), e->direction, e->stop, e->most, e->from_zero, EXPR_UNDEF };
        if (e->from_flat)
            watch[k].second = enclosed_rate(st, watch[k].rate, problem->variable, problem->n, problem->time, problem->field);
    }
}
