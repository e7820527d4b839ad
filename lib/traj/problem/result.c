/* What a motion is asked for, whether it is one of pieces; its result: what holds of it whatever was asked for, and its release. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ode.h"
#include "trajectory.h"

bool traj_beyond_double(const struct traj_request *request)
{
    static const double DOUBLE_REACHES = 1e-13;        /* down to this double may do */
    return request->exact_time && request->rtol < DOUBLE_REACHES && request->atol < DOUBLE_REACHES;
}

bool traj_in_pieces(const struct traj_request *rq)
{
    bool any = false;
    for (int e = 0; e < rq->events; e++)
        any |= rq->event[e].sets > 0 || rq->event[e].turns;
    return any;
}

/* b is not before a, but for what roundings of their size make: events at once are found a rounding apart. */
static bool in_order(double a, double b, double direction)
{
    static const double SAME_TIME = 1e-12;
    return (b - a) * direction >= -SAME_TIME * (fabs(a) + fabs(b));
}

/* Samples are the first of those that were asked for; all of them, unless the motion ended. */
static bool rows_sane(const struct traj_request *rq, const struct traj_result *r)
{
    bool sane = r->rows >= 0 && r->rows <= rq->samples && (r->ended || r->rows == rq->samples);
    for (int i = 0; i < r->rows && sane; i++)
        sane = r->t[i] == rq->times[i] && !(r->error && r->error[i] < 0);
    return sane && (!r->rows || r->columns == (rq->outputs ? rq->outputs : r->columns));
}

bool traj_result_sane(const struct traj_request *asked, const struct traj_result *r)
{
    const struct traj_request *rq = asked->carried ? asked->carried->rq : asked;      /* its columns are those of variables and derivatives */
    double direction = rq->times[rq->samples - 1] < rq->start ? -1 : 1;
    bool sane = rows_sane(rq, r) && r->ended_event >= -1 && r->ended_event < rq->events;
    for (int i = 0; i < r->happened && sane; i++)
        sane = r->happening[i].event >= 0 && r->happening[i].event < rq->events && in_order(i ? r->happening[i - 1].t : rq->start, r->happening[i].t, direction);
    for (int i = 1; i < r->legs && sane; i++)
        sane = in_order(r->leg[i - 1].t, r->leg[i].t, direction);
    for (int i = 0; i < r->slides && sane; i++)
        sane = isnan(r->slide[i].to) || in_order(r->slide[i].from, r->slide[i].to, direction);
    for (int i = 1; i < r->charts && sane; i++)
        sane = in_order(r->chart[i - 1].t, r->chart[i].t, direction);
    return sane;
}

void traj_take_end(struct traj_result *r, const struct traj_result *from)
{
    r->ended = from->ended;
    r->ended_t = from->ended_t;
    r->ended_error = from->ended_error;
    r->ended_reason = from->ended_reason;
    memcpy(r->ended_detail, from->ended_detail, sizeof r->ended_detail);
}

void traj_result_clear(struct traj_result *r)
{
    free(r->initial);
    free(r->relation);
    free(r->t);
    free(r->value);
    free(r->error);
    free(r->column_error);
    free(r->unit);
    for (size_t i = 0; r->digits && i < (size_t)r->rows * (size_t)r->columns; i++)
        free(r->digits[i]);
    free(r->digits);
    free(r->radius);
    free(r->happening);
    free(r->drift);
    for (int i = 0; i < r->charts; i++)
        free(r->chart[i].pivot);
    free(r->chart);
    for (int i = 0; i < r->passes; i++)
        free(r->passed[i].detail);
    free(r->passed);
    for (int i = 0; i < r->legs; i++)
        free(r->leg[i].impulse);
    free(r->leg);
    free(r->slide);
    free(r->happened_value);
    free(r->held_argument);
    free(r->held);
    for (size_t i = 0; r->happened_digits && i < (size_t)r->happened * ((size_t)r->columns + 1); i++)
        free(r->happened_digits[i]);
    free(r->happened_digits);
    *r = (struct traj_result){ 0 };
}

void traj_end_by_errors(struct traj_result *r)
{
    r->ended_reason = ode_reason_text(ODE_TOLERANCE);
    r->ended_error = 0;
    snprintf(r->ended_detail, sizeof r->ended_detail, "%s", ode_by_errors);
}
