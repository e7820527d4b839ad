/* One trajectory of the answer's system. In the form operator it ends at the first singular time beyond its
 * start (source 2, remark 4.3), which is known exactly: the integration stops just before it, and
 * whatever the numbers did near there, the end that is given is that time. */
#include "run_job.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "error.h"
#include "integrate.h"
#include "operator.h"
#include "operator_answer.h"
#include "request.h"
#include "text.h"
#include "trajectory.h"

/* Distances, relative to the span: where the integration stops before a singular time, and up
 * to where an end is taken for it. */
static const double BEFORE = 1e-9, NEAR = 1e-6;

/* The first time of a list beyond the start, not past the last sample; or NULL. */
static const struct op_singular *first_of(const struct op_singular_times *s, double start, double last)
{
    double direction = last < start ? -1 : 1;
    const struct op_singular *first = NULL;
    for (int k = 0; k < s->count; k++) {
        double t = s->at[k].t;
        bool ahead = direction * (t - start) > 0 && direction * (last - t) >= 0;
        if (ahead && (!first || direction * (first->t - t) > 0))
            first = s->at + k;
    }
    return first;
}

static const struct op_singular *first_stop(const struct job *j, const struct traj_request *r)
{
    if (!j->op || !j->op->solvable || !r->samples)
        return NULL;
    double last = r->times[r->samples - 1];
    const struct op_singular *a = first_of(&j->op->singular, r->start, last), *b = first_of(&j->op->poles, r->start, last);
    if (!a || !b)
        return a ? a : b;
    return fabs(a->t - r->start) <= fabs(b->t - r->start) ? a : b;
}

/* A pole at the start: nothing determines the motion there. */
static bool starts_well(const struct job *j, double start, struct sga_error *err)
{
    const struct op_singular_times *list[] = { &j->op->singular, &j->op->poles };
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < list[i]->count; k++)
            if (list[i]->at[k].t == start && list[i]->at[k].lost != OP_ZERO)
                return sga_fail_at(err, SGA_E_NO_MOTION, "/trajectory/start", "%.17g is a singular time: %s a pole there, so that the "
                                   "motion is not determined; start elsewhere", start,
                                   i ? "the coefficients have" : "the leading transfer coefficient has");
    return true;
}

static void say(const struct job *j, const struct op_singular *s, struct traj_result *r)
{
    struct sga_buf root = { 0 };
    int order = j->op->laurent.first;
    const char *time = j->request->store.symbol[j->request->system.time].name;
    op_text_polynomial(&root, s->polynomial, time);
    r->ended = true;
    r->ended_t = s->t;
    r->ended_error = DBL_EPSILON * fabs(s->t) + DBL_MIN;       /* a root that is known exactly */
    r->ended_reason = "singular_time";
    if (s->lost == OP_COEFFICIENT)
        snprintf(r->ended_detail, sizeof r->ended_detail, "%s = %.17g, a root of %.100s, is a pole of the coefficients (order %d): "
                 "the equations say nothing there", time, s->t, root.data, s->order);
    else
        snprintf(r->ended_detail, sizeof r->ended_detail, "%s = %.17g, a root of %.100s, is a singular time: the leading transfer "
                 "coefficient (order %d) %s order %d there", time, s->t, root.data, order,
                 s->lost == OP_POLE ? "has a pole of" : "vanishes to", s->order);
    sga_buf_free(&root);
}

static void move_events(struct traj_result *to, struct traj_result *from)
{
    for (size_t i = 0; to->happened_digits && i < (size_t)to->happened * ((size_t)to->columns + 1); i++)
        free(to->happened_digits[i]);
    free(to->happened_digits);
    to->happened_digits = NULL;
    free(to->happening);
    free(to->happened_value);
    to->happening = from->happening;
    to->happened = from->happened;
    to->happened_value = from->happened_value;
    from->happening = NULL;
    from->happened_value = NULL;
    from->happened = 0;
    to->ended_event = from->ended_event;
}

/* What else happens up to just before the singular time: another end, events. In double. */
static bool look_ahead(const struct job *j, const struct sga_solution *solution, const struct traj_request *request,
                       double before, double near, const struct op_singular *s, struct traj_result *result, struct sga_error *err)
{
    struct traj_request r = *request;
    struct traj_result ahead;
    r.times = &before;
    r.samples = 1;
    r.arithmetic = TRAJ_DOUBLE;
    r.exact_initial = r.exact_time = NULL;
    if (!traj_run(&j->request->system, solution, &r, &ahead, err))
        return false;
    if (request->events)
        move_events(result, &ahead);
    if (ahead.ended && (ahead.ended_event >= 0 || fabs(ahead.ended_t - s->t) > near)) {
        traj_take_end(result, &ahead);
    } else {
        say(j, s, result);
    }
    traj_result_clear(&ahead);
    return true;
}

bool answer_integrate(const struct job *j, const struct sga_solution *solution, const struct traj_request *request,
                      struct traj_result *result, struct sga_error *err)
{
    if (j->op && j->op->solvable && !starts_well(j, request->start, err))
        return false;
    const struct op_singular *s = first_stop(j, request);
    if (!s)
        return traj_run(&j->request->system, solution, request, result, err);
    struct traj_request r = *request;
    double direction = s->t < r.start ? -1 : 1, span = fmax(fabs(s->t), fabs(s->t - r.start)), before = s->t - direction * BEFORE * span;
    r.samples = 0;
    while (r.samples < request->samples && direction * (s->t - r.times[r.samples]) > 0)
        r.samples++;
    if (!r.samples) {            /* all of them lie beyond: the motion up to there, without rows */
        r.times = &before;
        r.samples = 1;
        r.arithmetic = TRAJ_DOUBLE;
        r.exact_time = NULL;
    }
    if (!traj_run(&j->request->system, solution, &r, result, err))
        return false;
    if (r.times == &before)
        result->rows = 0;
    bool near = result->ended && result->ended_event < 0 && fabs(result->ended_t - s->t) <= NEAR * span;
    if (near)
        say(j, s, result);
    if (result->ended || look_ahead(j, solution, request, before, NEAR * span, s, result, err))
        return true;
    traj_result_clear(result);
    return false;
}
