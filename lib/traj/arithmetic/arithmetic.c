/* The arithmetic of a motion: see arithmetic.h. */
#include "arithmetic.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "charts.h"
#include "endings.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "in_double.h"
#include "mem.h"
#include "precise.h"
#include "rows_kept.h"
#include "sizes.h"
#include "tape.h"

/* What it takes in double-double, at most, where it was not asked for: steps times length of the field's tape, and all that implicit steps do. */
static const double MOST_LENGTH = 2e6, MOST_WORK = 1e9;
/* So many times that, where roundings end what double has. */
static const double ROUNDED = 20;
static const long MOST_STEPS = 300000;

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
    if (f->charts && f->charts->stop)      /* it is made once more */
        return true;
    if (!precise_run(f, sys, sol, rq, limits, &reason, r, err))
        return false;
    drop_at_edge(rq, reason, r);
    traj_explain_end(f, rq, reason, r);
    return true;
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
    double more = r->rounded ? ROUNDED : 1, steps = fmin((double)MOST_STEPS, more * MOST_LENGTH / (50 + num_tape_length(f->field->direct)));
    *fine = (struct traj_result){ .moved = r->moved };
    if (!precise_possible(f, rq, &why) || !rq->exact_time || (double)r->steps > 4 * steps)
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
    bool needed = traj_beyond_double(rq), there = needed && try_precise(f, sys, sol, rq, r, &fine);
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
