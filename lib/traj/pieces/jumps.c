/* Motions with events that set variables: their errors, by a second motion. */
#include "jumps.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "jump_boxed.h"
#include "jump_exact.h"
#include "jump_fine.h"
#include "jump_pass.h"
#include "larger.h"
#include "mem.h"
#include "ode.h"
#include "rows_kept.h"
#include "slide.h"
#include "tolerance.h"

/* Motions that are compared at the most, and the steps by which the tolerances shrink; what is set is wrong by so much in the looser motion. */
enum { MOST_PASSES = 4, FINE_PASSES = 2 };      /* in double-double pieces are refined themselves, and only the first is made wrong */
static const double TIGHTER = 0.1, WRONG = 4 * DBL_EPSILON, WRONG_FINE = 4 * NUM_DD_EPSILON;
/* Beyond a singular position, where a piece's own estimate says nothing of how it came there: times the difference of the two motions. */
static const double OVER = 4;

/* How many happenings both have, in the same order. */
static int alike(const struct traj_result *a, const struct traj_result *b)
{
    int k = 0;
    while (k < a->happened && k < b->happened && a->happening[k].event == b->happening[k].event && a->happening[k].direction == b->happening[k].direction)
        k++;
    return k;
}

/* A difference of two motions can pass through 0 where their errors do not: it is raised towards the larger of those beside it. */
static double raised(const struct jump_pass *p, int row, int column)
{
    size_t columns = (size_t)p->r.columns;
    const double *e = p->each + (size_t)row * columns + (size_t)column;
    double before = row > 0 ? e[-(ptrdiff_t)columns] : 0, after = row + 1 < p->r.rows ? e[columns] : 0;
    double near = fmax(isfinite(before) ? before : 0, isfinite(after) ? after : 0);
    return fmax(*e, fmin(near, ODE_NEIGHBOUR * *e));
}

/* Errors of the tighter motion by the looser one; the largest, in units of what is allowed. */
static double compare(struct jump_pass *p, const struct jump_pass *loose, const struct traj_request *rq)
{
    struct traj_result *r = &p->r;
    const struct traj_result *o = &loose->r;
    const struct sga_tolerance asked = { rq->rtol, rq->atol };
    double direction = jump_direction(rq), known = INFINITY, worst = 0;
    int same = alike(r, o), columns = r->columns, jumped = 0;
    SGA_FREED double *largest = sga_calloc((size_t)columns + 1, sizeof *largest);
    if (same < r->happened)
        known = direction * r->happening[same].t;
    if (same < o->happened)
        known = fmin(known, direction * o->happening[same].t);
    r->error = sga_calloc((size_t)r->rows + 1, sizeof(double));
    r->column_error = sga_calloc((size_t)columns + 1, sizeof(double));
    r->error_estimate = 0;
    for (int i = 0; i < r->rows; i++) {
        bool there = i < o->rows && direction * r->t[i] <= known + jump_at_once(p, rq, r->t[i]), over = r->passes && direction * (r->t[i] - r->passed[0].t) > 0;
        while (jumped < p->jumps && direction * (p->at[jumped] - r->t[i]) <= 0)
            jumped++;
        for (int k = 0; k < columns; k++) {
            size_t at = (size_t)i * (size_t)columns + (size_t)k;
            largest[k] = sga_larger(largest[k], fabs(r->value[at]));
            /* each piece begins with roundings of what the values there are, and both motions may have them alike */
            double rounding = 4 * jump_epsilon(r) * (fabs(r->value[at]) + jumped * largest[k]);
            double e = there ? (over ? OVER : 1) * jump_difference(r, o, at) + p->each[at] + rounding : INFINITY;
            p->each[at] = isnan(e) ? INFINITY : e;
        }
    }
    for (int i = 0; i < r->rows; i++) {
        for (int k = 0; k < columns; k++) {
            double e = raised(p, i, k);
            r->error[i] = fmax(r->error[i], e);
            r->column_error[k] = fmax(r->column_error[k], e);
            worst = fmax(worst, sga_error_ratio(e, asked, r->unit ? r->unit[k] : 1, r->value[(size_t)i * (size_t)columns + (size_t)k]));
        }
        r->error_estimate = fmax(r->error_estimate, r->error[i]);
    }
    for (int i = 0; i < r->slides; i++) {
        struct traj_slide *a = r->slide + i;
        const struct traj_slide *b = i < o->slides && o->slide[i].surface == a->surface ? o->slide + i : NULL;
        a->error = b ? fabs(a->from - b->from) + (isnan(a->to) && isnan(b->to) ? 0 : fabs(a->to - b->to)) + 16 * DBL_EPSILON * fmax(fabs(a->from), isnan(a->to) ? 0 : fabs(a->to)) : INFINITY;
        a->error = isnan(a->error) ? INFINITY : a->error;
    }
    for (int i = 0; i < r->happened; i++) {
        struct traj_happening *h = r->happening + i;
        bool last = i >= same && direction * (rq->times[rq->samples - 1] - h->t) <= jump_at_once(p, rq, h->t);      /* one of them ends before it, by a rounding */
        double own = isfinite(h->error) ? h->error : 0;
        h->error = i < same ? jump_time_difference(r, i, o, i) + own + 4 * jump_epsilon(r) * fabs(h->t) : last ? own + jump_at_once(p, rq, h->t) : INFINITY;
        if (i < same && !rq->event[h->event].turns)      /* of those slides say it, and what it does to the motion is in the samples */
            worst = fmax(worst, sga_error_ratio(h->error, asked, 1, h->t));
    }
    return worst;
}

static bool has_place(const struct traj_result *r)
{
    return r->ended && !jump_time_ended(r) && strcmp(r->ended_reason, ode_reason_text(ODE_STEP_LIMIT)) != 0 && strcmp(r->ended_reason, ode_reason_text(ODE_TOLERANCE)) != 0;
}

/* What is known of the time of the end; of an accumulation its text says it too. */
static void say_end(struct jump_pass *p, const struct jump_pass *loose, double rtol, double start, double worst)
{
    struct traj_result *r = &p->r;
    bool limit = r->ended && strcmp(r->ended_reason, "accumulation") == 0;
    bool both = has_place(r) && has_place(&loose->r) && (!limit || strcmp(loose->r.ended_reason, "accumulation") == 0);
    double e = p->end_error + (both ? fabs(r->ended_t - loose->r.ended_t) : INFINITY);
    double of_t = isfinite(e) ? (limit ? e : ode_end_error(e, rtol, r->ended_t - start)) + 4 * jump_epsilon(r) * fabs(r->ended_t) : 0;
    r->ended_error = limit || worst <= 1 ? of_t : 0;
    if (!limit && r->ended && r->ended_event < 0 && strcmp(r->ended_reason, ode_reason_text(ODE_CONSTRAINT_LOST)) != 0 && ode_time_is_lost(of_t, r->ended_t - start))
        traj_end_by_errors(r);      /* as in lib/ode/global.c */
    if (!limit)
        return;
    size_t end = strlen(r->ended_detail);
    if (isfinite(e))
        snprintf(r->ended_detail + end, sizeof r->ended_detail - end, " (the time is known to %.2g)", e);
    else
        snprintf(r->ended_detail + end, sizeof r->ended_detail - end, " (how well the time is known is not)");
}

/* The digits that the errors of the whole leave. */
static void write_digits(struct jump_pass *p)
{
    struct traj_result *r = &p->r;
    size_t columns = (size_t)r->columns;
    for (size_t i = 0; i < (size_t)r->rows * columns; i++)
        r->digits[i] = jump_fine_text(r->digits[i], p->each[i]);
    for (size_t i = 0; i < (size_t)r->happened * (columns + 1); i++)
        r->happened_digits[i] = jump_fine_text(r->happened_digits[i], i % (columns + 1) ? r->error_estimate : r->happening[i / (columns + 1)].error);
}

/* A pass after the first: tighter, compared with it. */
enum later { COMPARED, LAST_STAYS, FAILED };
static enum later later_pass(struct jump_pass *p, struct jump_pass *loose, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double tighter,
                             struct sga_error *err)
{
    bool errors = loose->r.error, ok = jump_pass_run(p, sys, sol, rq, tighter, 0, err);
    bool stays = errors && rows_are_kept(rq) && rows_may_end(rq, NULL) && (ok ? jump_time_ended(&p->r) && p->r.rows < loose->r.rows : err->code == SGA_E_LIMIT_SECONDS);
    if (stays) {
        jump_pass_clear(p);
        *p = *loose;
        *err = (struct sga_error){ 0 };
        return LAST_STAYS;
    }
    if (!ok)
        jump_pass_clear(loose);
    return ok ? COMPARED : FAILED;
}

/* Roundings ended the tighter motion before a singular position that the one before has passed. */
static bool falls_short(const struct jump_pass *p, const struct jump_pass *loose, const struct traj_request *rq)
{
    return p->r.ended && !jump_time_ended(&p->r) && loose->r.passes > p->r.passes && (!loose->r.ended || jump_direction(rq) * (loose->r.ended_t - p->r.ended_t) > 0);
}

/* The first is the motion then, compared with one that is looser yet. */
static bool take_looser(struct jump_pass *p, struct jump_pass *loose, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq)
{
    struct jump_pass other;
    struct sga_error ignored = { 0 };
    if (!jump_pass_run(&other, sys, sol, rq, 1 / TIGHTER, 0, &ignored))
        return false;
    if (other.r.passes < loose->r.passes) {
        jump_pass_clear(&other);
        return false;
    }
    jump_pass_clear(p);
    *p = *loose;
    *loose = other;
    return true;
}

/* The first, within its part of the time. *late: that ended, and the samples of *part are those that there are; what it is compared with has the rest. */
static bool first_pass(struct jump_pass *loose, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_request *part, bool *late,
                       struct sga_error *err)
{
    *part = *rq;
    part->rows_until = rows_are_kept(rq) ? rows_first_until(rq->rows_until) : 0;
    if (!jump_pass_run(loose, sys, sol, part, 1, jump_fine_any(rq) ? WRONG_FINE : jump_is_exact(rq) ? 0 : WRONG, err))
        return false;
    part->rows_until = rows_are_kept(rq) ? rq->rows_until : 0;
    *late = jump_time_ended(&loose->r);
    if (!*late)
        return true;
    part->samples = loose->r.rows;
    if (rows_beyond_start(rq, loose->r.rows, err))
        return true;
    jump_pass_clear(loose);
    return false;
}

static const char *shortfall_of(double worst, bool late)
{
    return late ? rows_shortfall
           : isinf(worst) ? "the motions that were compared do not have the same events"
                          : "errors that events that set variables carry on are larger than the tolerances, at tighter ones too";
}

/* Passes in the arithmetic of the request, each tighter, until two agree to the tolerances. */
static bool in_passes(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err)
{
    struct jump_pass loose, p;
    struct traj_request part;
    double tighter = 1, worst = INFINITY, before;
    bool late;
    *r = (struct traj_result){ 0 };
    if (rq->single) {
        bool ok = jump_pass_run(&p, sys, sol, rq, tighter, 0, err);
        *r = ok ? p.r : *r;
        p.r = (struct traj_result){ 0 };
        if (ok)
            jump_pass_clear(&p);
        return ok;
    }
    if (!first_pass(&loose, sys, sol, rq, &part, &late, err))
        return false;
    for (int k = 1;; k++) {
        tighter *= TIGHTER;
        enum later how = later_pass(&p, &loose, sys, sol, &part, tighter, err);
        if (how == FAILED)
            return false;
        late |= how == LAST_STAYS || jump_time_ended(&p.r);
        if (how == LAST_STAYS)
            break;
        if (late && (!p.r.ended || jump_time_ended(&p.r)))
            jump_end_at_rows(&p, rq, p.r.ended ? p.r.ended_detail : loose.r.ended_detail);
        before = worst;
        bool back = !late && falls_short(&p, &loose, rq);
        if (back && k > 1) {      /* that has been compared */
            jump_pass_clear(&p);
            p = loose;
            break;
        }
        back = back && take_looser(&p, &loose, sys, sol, &part);
        worst = compare(&p, &loose, rq);
        say_end(&p, &loose, rq->rtol / tighter, rq->start, worst);
        jump_pass_clear(&loose);
        if (worst <= 1 || late || back || k + 1 >= (p.fine ? FINE_PASSES : MOST_PASSES) || (isfinite(before) && worst > 0.5 * before))
            break;
        loose = p;
    }
    if (worst <= 1)
        p.r.shortfall = NULL;
    else if (!p.r.shortfall)
        p.r.shortfall = shortfall_of(worst, late);
    jump_drop_turns(&p.r, rq);
    if (p.fine)
        write_digits(&p);
    p.r.out_of_time = rows_are_kept(rq) && (late || sga_now() >= rq->rows_until);
    *r = p.r;
    p.r = (struct traj_result){ 0 };
    jump_pass_clear(&p);
    return true;
}

/* In double-double, where double does not reach the tolerances: in a part of the time, and to the tolerances; otherwise there is nothing in *r. */
static bool in_longer(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r)
{
    static const double PART = 0.4;
    struct traj_request q = *rq;
    struct sga_budget part;
    struct sga_error ignored = { 0 };
    if (rq->budget && rq->budget->deadline > 0) {
        double now = sga_now();
        rows_request(rq, now + PART * fmax(rq->budget->deadline - now, 0), &q, &part);
    }
    q.arithmetic = TRAJ_DOUBLE_DOUBLE;
    q.rows_until = 0;
    if (!in_passes(sys, sol, &q, r, &ignored))
        return false;
    if (!r->shortfall && !r->out_of_time)
        return true;
    traj_result_clear(r);
    return false;
}

bool jumps_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err)
{
    *r = (struct traj_result){ 0 };
    if (rq->arithmetic == TRAJ_BALL)
        return jump_boxed_run(sys, sol, rq, r, err);
    if (rq->arithmetic == TRAJ_AUTO && !rq->single && traj_beyond_double(rq) && in_longer(sys, sol, rq, r))
        return true;
    return in_passes(sys, sol, rq, r, err);
}
