/* The arithmetic of a motion: see arithmetic.h. */
#include "arithmetic.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "charts.h"
#include "endings.h"
#include "flow.h"
#include "in_double.h"
#include "mem.h"
#include "precise.h"
#include "rows_kept.h"
#include "sizes.h"
#include "tape.h"

/* Down to this double arithmetic may do; what it takes in double-double, at most, where it was not asked
 * for: steps times length of the field's tape, and all that implicit steps do. */
static const double DOUBLE_REACHES = 1e-13;
static const double MOST_LENGTH = 2e6, MOST_WORK = 1e9;
/* So many times that, where roundings end what double has. */
static const double ROUNDED = 20;
static const long MOST_STEPS = 300000;

/* The motion in double, on which events are found before they are located in double-double. Not too tight, since what
 * comes near to 0 is found as a touch then, and looked at again: by natural sizes, as an atol that is meant as it is may be finer than any double. Both directions are found, and nothing
 * stops: a touch may turn out to be two passages, or none. */
static const double GUIDE_RTOL = 1e-9;

/* Where the request's own atol is finer than a guide's: the flow's sizes with natural units of absolute tolerances, of `natural`. Weights stay the flow's, as charts that are added on
 * the way point to them. Otherwise NULL. sizes_clear(natural) is due. */
static struct sizes *guide_sizes(const struct flow *f, const struct traj_request *rq, struct traj_request *q, struct sizes *natural, struct sizes *to)
{
    *natural = (struct sizes){ .n = 0 };
    if (!rq->own_atol || rq->atol >= GUIDE_RTOL)
        return NULL;
    q->own_atol = false;
    sizes_init(natural, f->sys, q);
    *to = *f->sizes;
    to->unit = natural->unit;
    to->column = natural->column;
    to->time = natural->time;
    to->any = natural->any;
    return to;
}

static bool find_events(struct flow *f, const struct traj_request *rq, const double *start, struct traj_result *guide, struct sga_error *err)
{
    struct traj_request q = *rq;
    size_t n = (size_t)f->n, events = (size_t)rq->events;
    struct traj_event *event = memcpy(sga_malloc(events * sizeof *event), rq->event, events * sizeof *event);
    struct sizes *own = f->sizes, natural, guiding;
    struct ode_event *asked = memcpy(sga_malloc(events * sizeof *asked), f->spec, events * sizeof *asked);
    for (size_t i = 0; i < events; i++) {
        event[i].direction = 0;
        event[i].stop = false;
        f->spec[i] = (struct ode_event){ 0, false };
    }
    q.event = event;
    q.arithmetic = TRAJ_DOUBLE;
    q.rtol = fmax(rq->rtol, GUIDE_RTOL);
    q.atol = fmax(rq->atol, GUIDE_RTOL);
    struct sizes *guides = guide_sizes(f, rq, &q, &natural, &guiding);
    f->sizes = guides ? guides : own;
    q.integrals = 0;
    q.rows_until = rows_are_kept(rq) ? rows_first_until(rq->rows_until) : 0;
    q.single = false;
    *guide = (struct traj_result){ .initial = memcpy(sga_malloc((n + 1) * sizeof *start), start, n * sizeof *start) };
    bool ok = in_double_run(f, &q, guide, err);
    f->sizes = own;
    sizes_clear(&natural);
    memcpy(f->spec, asked, events * sizeof *asked);
    free(asked);
    free(event);
    return ok;
}

static bool by_time(const struct traj_result *r)
{
    return r->ended && strcmp(r->ended_reason, ode_reason_text(ODE_TIME_LIMIT)) == 0;
}

/* Nothing is known of events beyond the end of the motion in double. */
static bool guided(const struct traj_result *guide, const struct traj_request *rq, const struct traj_result *r, struct sga_error *err)
{
    double last = rq->times[rq->samples - 1], way = last - rq->start, end = r->ended ? r->ended_t : last;
    double beyond = way < 0 ? guide->ended_t - end : end - guide->ended_t;
    if (!guide->ended || beyond <= (guide->ended_event < 0 ? 1e-3 : 1e-6) * fabs(way))
        return true;
    return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/events", "what happens is found in double first, where the motion ends at %.10g (%s); "
                       "ask for an earlier stop, or leave trajectory.events out", guide->ended_t, guide->ended_reason);
}

/* The same, in longer numbers: a sample at the very edge of what must have values may lie beyond it. */
static void drop_at_edge(const struct traj_request *rq, enum ode_reason reason, struct traj_result *r)
{
    double near = rq->rtol * fmax(fabs(r->ended_t), fabs(r->ended_t - rq->start));
    size_t cols = (size_t)r->columns;
    while (rq->valueds && reason == ODE_LEFT_DOMAIN && r->rows > 1 && fabs(r->t[r->rows - 1] - r->ended_t) <= near) {
        r->rows--;
        for (size_t j = 0; r->digits && j < cols; j++)
            free(r->digits[(size_t)r->rows * cols + j]);
    }
}

static bool precise(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                    struct precise_limits limits, struct traj_result *r, struct sga_error *err)
{
    enum ode_reason reason;
    struct traj_result guide = { 0 };
    struct traj_request part = *rq;
    bool ok = !rq->events || find_events(f, rq, r->initial, &guide, err), late = by_time(&guide);
    if (ok && f->charts && (f->charts->stop || (ended_by_pivots(&guide) && charts_add(f)))) {      /* it is made once more, and its guide */
        traj_result_clear(&guide);
        return true;
    }
    if (late)       /* as far as events are known */
        part.samples = guide.rows;
    ok = ok && precise_run(f, sys, sol, &part, rq->events ? &guide : NULL, limits, &reason, r, err);
    if (ok)
        drop_at_edge(rq, reason, r);
    if (ok)
        traj_explain_end(f, rq, reason, r);
    if (ok && late && !r->ended) {
        traj_take_end(r, &guide);
        r->ended = true;
    }
    ok = ok && (!rq->events || guided(&guide, rq, r, err));
    traj_result_clear(&guide);
    return ok;
}

/* Double alone no longer tells points of the set from others (long chains of constraints amplify its roundings). */
static bool constraints_lost(const struct traj_result *r)
{
    return r->ended && strcmp(r->ended_reason, "constraint_lost") == 0;
}

/* In double-double where that was not asked for: only if it can be, and is not long. r->initial and
 * what r says of double (steps, 0 at first) are looked at. False: there is nothing in *fine. */
static bool try_precise(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                        const struct traj_result *r, struct traj_result *fine)
{
    const char *why;
    struct sga_error ignored = { 0 };
    double more = r->rounded ? ROUNDED : 1, steps = fmin((double)MOST_STEPS, more * MOST_LENGTH / (50 + num_tape_length(f->field.direct)));
    *fine = (struct traj_result){ .moved = r->moved };
    if (rq->events || !precise_possible(f, rq, &why) || !rq->exact_time || (double)r->steps > 4 * steps)
        return false;
    fine->initial = memcpy(sga_malloc((size_t)f->n * sizeof *fine->initial), r->initial, (size_t)f->n * sizeof *fine->initial);
    if (precise(f, sys, sol, rq, (struct precise_limits){ (long)steps, more * MOST_WORK }, fine, &ignored))
        return true;
    traj_result_clear(fine);
    return false;
}

static bool lost_by_rounding(const struct traj_result *r, const struct traj_result *fine)
{
    return constraints_lost(r) && !fine->ended;
}

/* Double arithmetic, and what double-double has beside it: the samples are those of the longer numbers where
 * there are as many; of endings that differ, that of double, which has more ways to go on. */
static void choose(struct traj_result *r, struct traj_result *fine)
{
    struct traj_result other = *r;
    if (lost_by_rounding(r, fine)) {
        *r = *fine;
        traj_result_clear(&other);
        return;
    }
    if (fine->rows < r->rows) {
        traj_result_clear(fine);
        return;
    }
    *r = *fine;
    if (constraints_lost(&other) && fine->ended) {
        traj_result_clear(&other);
        return;
    }
    if (other.ended != fine->ended || (other.ended && strcmp(other.ended_reason, fine->ended_reason) != 0))
        traj_take_end(r, &other);
    traj_result_clear(&other);
}

/* The cheapest arithmetic that reaches the tolerances. */
static bool solve_cheapest(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                           struct traj_result *r, struct sga_error *err)
{
    struct traj_result fine;
    bool needed = rq->rtol < DOUBLE_REACHES && rq->atol < DOUBLE_REACHES, there = needed && try_precise(f, sys, sol, rq, r, &fine);
    if (there && (!fine.ended || fine.out_of_time)) {
        traj_result_clear(r);
        *r = fine;
        return true;
    }
    if (!in_double_run(f, rq, r, err)) {
        if (there)
            traj_result_clear(&fine);
        return false;
    }
    if (there) {
        choose(r, &fine);
    } else if (!needed && !r->out_of_time && ((r->shortfall && !r->beside) || constraints_lost(r)) && try_precise(f, sys, sol, rq, r, &fine)) {
        /* rounding in double: perhaps longer numbers are enough */
        if (fine.shortfall && !lost_by_rounding(r, &fine))
            traj_result_clear(&fine);
        else
            choose(r, &fine);
    }
    return true;
}

bool in_arithmetic(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                   struct traj_result *r, struct sga_error *err)
{
    const char *why;
    if (rq->arithmetic == TRAJ_DOUBLE_DOUBLE && !precise_possible(f, rq, &why))
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/accuracy/arithmetic", "%s", why);
    if (rq->arithmetic == TRAJ_DOUBLE_DOUBLE)
        return precise(f, sys, sol, rq, (struct precise_limits){ MOST_STEPS, INFINITY }, r, err);
    return rq->arithmetic == TRAJ_AUTO ? solve_cheapest(f, sys, sol, rq, r, err) : in_double_run(f, rq, r, err);
}
