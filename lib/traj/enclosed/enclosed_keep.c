/* From boxes to the result of a motion: decimal texts with their radii. */
#include "enclosed_attempt.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ball.h"
#include "buf.h"
#include "flow.h"
#include "mem.h"
#include "ode.h"
#include "print.h"
#include "reduction.h"
#include "system.h"
#include "trajectory.h"

/* Why there is no proof beyond. */
static void say_end(const struct attempt *a, struct traj_result *r)
{
    struct sga_buf text = { 0 };
    r->ended = a->end.why != ENCLOSE_DONE;
    r->ended_t = a->end.t;
    r->ended_event = -1;
    if (!r->ended)
        return;
    r->ended_reason = a->end.why == ENCLOSE_STOPPED ? ode_reason_text(ODE_TIME_LIMIT) : "not_enclosed";
    if (a->end.why == ENCLOSE_STOPPED) {
        attempt_say_time(a, r->ended_detail, sizeof r->ended_detail);
    } else if (a->end.why == ENCLOSE_EVENT) {
        r->ended_event = a->end.which;
        r->ended_reason = ode_reason_text(ODE_EVENT);
        snprintf(r->ended_detail, sizeof r->ended_detail, "an event that stops the motion");
    } else if (a->end.why == ENCLOSE_UNDECIDED) {
        snprintf(r->ended_detail, sizeof r->ended_detail, "it cannot be shown whether an event that %s happens here: its function comes near to 0, and neither a "
                 "change of its sign nor that it stays away from 0 can be shown", a->rq->piece ? "stops the motion or sets something" : "stops the motion");
    } else if (a->end.why == ENCLOSE_WIDE)
        snprintf(r->ended_detail, sizeof r->ended_detail, "the enclosure grows too wide here with %ld bits: neighbouring solutions part too fast; "
                 "ask for a shorter time, or use \"double\"", (long)a->prec);
    else if (a->end.why == ENCLOSE_JUMPS)
        snprintf(r->ended_detail, sizeof r->ended_detail, "the constraints jump here with a table, and it cannot be shown where the variables that jump with it go; put samples beside "
                 "each other in the place of the step, or use \"double\"");
    else if (a->end.why == ENCLOSE_MAY_VANISH && expr_print(a->sys->store, a->problem.nonzero[a->end.which], 90, &text))
        snprintf(r->ended_detail, sizeof r->ended_detail, "it cannot be shown that %s, which the reduction divides by or holds on one side of, is not 0 "
                 "beyond this time", text.data);
    else
        snprintf(r->ended_detail, sizeof r->ended_detail, "beyond this time it cannot be shown that the solution exists and the field is analytic along it: "
                 "a pole, the edge of a domain, a fall of the rank (a linkage at its dead centre), or a change of branch (abs, sign, min, max, a root of 0)");
    sga_buf_free(&text);
}

static void numbers(const struct attempt *a, struct traj_result *r)
{
    size_t total = (size_t)a->end.samples * (size_t)a->columns;
    assert(a->end.samples >= 0 && a->end.samples <= a->rq->samples && (a->end.why != ENCLOSE_DONE || a->end.samples == a->rq->samples));
    r->rows = a->end.samples;
    r->columns = a->columns;
    r->t = sga_malloc((size_t)(r->rows + 1) * sizeof *r->t);
    r->value = sga_malloc((total + 1) * sizeof *r->value);
    r->radius = sga_malloc((total + 1) * sizeof *r->radius);
    r->digits = sga_calloc(total + 1, sizeof *r->digits);
    r->error = sga_calloc((size_t)r->rows + 1, sizeof *r->error);
    for (int i = 0; i < r->rows; i++) {
        r->t[i] = a->rq->times[i];
        for (int k = 0; k < r->columns; k++) {
            size_t at = (size_t)i * (size_t)r->columns + (size_t)k;
            r->digits[at] = enclose_decimal(a->column + at, a->prec, r->radius + at);
            r->value[at] = r->digits[at] ? strtod(r->digits[at], NULL) : NAN;
            r->error[i] = fmax(r->error[i], r->radius[at]);
        }
        r->error_estimate = fmax(r->error_estimate, r->error[i]);
    }
    r->column_error = traj_column_errors(r->radius, r->rows, r->columns);
}

/* Events, each as the rows are. */
static void keep_events(const struct attempt *a, struct traj_result *r)
{
    size_t all = (size_t)a->happened.count, cols = (size_t)r->columns;
    r->happened = a->happened.count;
    r->happening = sga_malloc((all + 1) * sizeof *r->happening);
    r->happened_value = sga_malloc((all + 1) * (cols + 1) * sizeof *r->happened_value);
    r->happened_digits = sga_calloc((all + 1) * (cols + 1), sizeof *r->happened_digits);
    for (size_t i = 0; i < all; i++) {
        const struct enclose_happening *h = a->happened.list + i;
        struct traj_happening *to = r->happening + i;
        char **digits = r->happened_digits + i * (cols + 1);
        double radius;
        *to = (struct traj_happening){ .event = h->which, .direction = h->direction, .undecided = !h->shown };
        digits[0] = enclose_decimal(&h->t, a->prec, &to->error);
        to->t = digits[0] ? strtod(digits[0], NULL) : NAN;
        for (size_t k = 0; k < cols; k++) {
            digits[1 + k] = enclose_decimal(a->happened_column + i * cols + k, a->prec, &radius);
            r->happened_value[i * cols + k] = digits[1 + k] ? strtod(digits[1 + k], NULL) : NAN;
        }
    }
}

/* Of the midpoints, which are not on the set exactly. */
static void residual(const struct attempt *a, struct traj_result *r)
{
    int c = a->sol->constraints;
    if (!c)
        return;
    struct num_ball b;
    struct expr_cone cone;
    expr_id *root = sga_malloc((size_t)c * sizeof *root);
    arb_ptr value = _arb_vec_init(c);
    mag_t m;
    for (int k = 0; k < c; k++)
        root[k] = a->sol->constraint[k].expr;
    num_ball_init(&b, a->sys->store, a->prec + 20);
    expr_cone_init(&cone);
    expr_cone_of(a->sys->store, &cone, root, c);
    mag_init(m);
    for (int i = 0; i < a->end.samples; i++) {
        for (int j = 0; j < a->n; j++)
            mag_zero(arb_radref(a->box + (size_t)i * (size_t)a->n + (size_t)j));
        knots_enter(&a->knots, a->before[i]);
        attempt_evaluate(a, &b, &cone, root, c, a->time + i, a->box + (size_t)i * (size_t)a->n, value);
        for (int k = 0; k < c; k++) {
            arb_get_mag(m, value + k);
            r->residual = fmax(r->residual, enclose_above(m));
        }
    }
    mag_clear(m);
    _arb_vec_clear(value, c);
    free(root);
    expr_cone_clear(&cone);
    num_ball_clear(&b);
}

void attempt_keep(const struct attempt *a, struct traj_result *r)
{
    say_end(a, r);
    numbers(a, r);
    if (a->rq->events)
        keep_events(a, r);
    residual(a, r);
    for (int j = 0; j < a->n; j++)
        r->initial[j] = arf_get_d(arb_midref(a->start + j), ARF_RND_NEAR);
    if (a->excess > 0)
        r->shortfall = a->last ? "the enclosures are rigorous but wider than the tolerances: the time granted ended before more bits could be tried"
                               : "the enclosures are rigorous but wider than the tolerances, with as many bits as are used at most";
    r->method = "taylor";
    r->arithmetic = "ball";
    r->steps = a->end.steps;
    r->evaluations = a->end.evaluations;
}
