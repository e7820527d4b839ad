/* Why a motion ends where it does: what is lost there, in words. */
#include "endings.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "charts.h"
#include "endings_far.h"
#include "field.h"
#include "impulse.h"
#include "leap.h"
#include "mem.h"
#include "points_space.h"
#include "print.h"
#include "reduction.h"
#include "redundant.h"
#include "system.h"
#include "trajectory.h"

/* A trajectory that reaches a stratum says what is lost there. */
static void say_stratum(struct flow *f, struct traj_result *r)
{
    SGA_FREED char *text = expr_text(f->sys->store, f->field->lost_pivot < 0 ? EXPR_UNDEF : f->field->pivot_expr[f->field->lost_pivot], 120);
    r->ended_reason = f->field->contradiction ? "gauge_contradiction" : "stratum";
    r->stratum = !f->field->contradiction;
    if (f->field->contradiction)
        snprintf(r->ended_detail, sizeof r->ended_detail, "the rates asked for contradict the equations beyond this time");
    else if (f->field->lost_pivot >= 0)
        snprintf(r->ended_detail, sizeof r->ended_detail, f->field->lost_pivot < f->field->sides
                 ? f->field->solution_side[f->field->lost_pivot].unseen
                   ? "the constraints were found on one side of %s = 0 only: no point of them was found beyond it, so what they say there is not known"
                   : "the constraints were found on one side of %s = 0 only: beyond it they say something else"
                 : "the rank of the equations drops where %s = 0: the motion is not determined beyond", text);
    else
        snprintf(r->ended_detail, sizeof r->ended_detail,
                 "the rank of the equations drops here: the motion is not determined beyond");
}

/* Relative roundings from which on constraints are lost by them, and not by the motion. */
static const double ROUNDED = 1e-11;

/* A denominator that came to 0 is named. */
static void say_pole(struct flow *f, bool grows, const char *how, struct traj_result *r)
{
    SGA_FREED char *text = expr_text(f->sys->store, f->field->pole_expr[f->field->lost_pole], 120);
    size_t before = grows ? strlen(r->ended_detail) : 0;
    snprintf(r->ended_detail + before, sizeof r->ended_detail - before,
             "%sthe equations divide by %s, which %s: the motion is not determined beyond", grows ? "; " : "", text, how);
}

/* The same where no step has come to its other side. */
static void tends_to_pole(struct flow *f, int pole, bool grows, struct traj_result *r)
{
    f->field->lost_pole = pole;
    r->ended_reason = "blow_up";
    say_pole(f, grows, "tends to 0", r);
}

/* The motion tends to a zero of the pivot. What is far out is no place of the set. */
static void tends_to_stratum(struct flow *f, const struct traj_request *rq, int pivot, struct traj_result *r)
{
    if (endings_far(f, rq, r) || endings_grows_with(f, rq, pivot, r))
        return;
    SGA_FREED char *text = expr_text(f->sys->store, f->field->pivot_expr[pivot], 120);
    endings_at_zero(f, rq, pivot, ENDINGS_NEAR, r);
    r->ended_reason = "stratum";
    r->stratum = true;
    snprintf(r->ended_detail, sizeof r->ended_detail, "the rank of the equations drops where %s = 0, which the motion tends to: it is not determined beyond", text);
}

/* Of the way made: how far from a zero of a pivot steps end that come to it. */
static const double BESIDE = 1e-4;

/* A rank that numbers lose drops before the zero of a pivot does it, where rows are large. And where a trial has passed the zero its time is known by a line,
 * which for a square root is twice too far. */
static void say_rank(struct flow *f, const struct traj_request *rq, struct traj_result *r)
{
    struct field *field = f->field;
    int pivot = field->lost_pivot < 0 && !field->contradiction ? field_approaches(field, r->initial, rq->start, r->ended_t, ENDINGS_NEAR, false, NULL) : -1;
    bool passed = pivot < 0 && field->lost_pivot >= field->sides && field->lost_pivot < field->chosen;
    if (pivot >= 0) {
        tends_to_stratum(f, rq, pivot, r);
        return;
    }
    if (passed)
        field_forget_trial(field);
    if (passed && endings_grows_with(f, rq, field->lost_pivot, r))
        return;
    say_stratum(f, r);
    if (passed)
        endings_at_zero(f, rq, field->lost_pivot, BESIDE, r);
}

/* A pivot of the gauge choice tends to 0 where it ends, and what grows does so for that. */
static bool say_rates(struct flow *f, const struct traj_request *rq, double apart, struct traj_result *r)
{
    int pivot = f->field->chosen < f->field->pivots ? field_approaches(f->field, r->initial, rq->start, r->ended_t, apart, true, NULL) : -1;
    size_t before = strlen(r->ended_detail);
    if (pivot < 0)
        return false;
    SGA_FREED char *text = expr_text(f->sys->store, f->field->pivot_expr[pivot], 120);
    snprintf(r->ended_detail + before, sizeof r->ended_detail - before, "; the rates asked for divide by %s, which tends to 0", text);
    return true;
}

/* It moves ever faster, and no pivot of the equations comes to 0. */
static bool say_steep(struct flow *f, const struct traj_request *rq, struct traj_result *r)
{
    if (!endings_steep(f, rq, r))
        return false;
    size_t before = strlen(r->ended_detail);
    if (!say_rates(f, rq, FIELD_SOON, r))
        snprintf(r->ended_detail + before, sizeof r->ended_detail - before, ", while nothing that the equations divide by comes to 0");
    return true;
}

/* What grows without bound may be what a stratum leaves undetermined, and what is lost by numbers may be lost beside one. False: there is no such place. */
static bool look_for_stratum(struct flow *f, const struct traj_request *rq, bool grows, struct traj_result *r)
{
    double apart = grows ? FIELD_SOON : ENDINGS_NEAR;
    int pole, pivot = field_approaches(f->field, r->initial, rq->start, r->ended_t, apart, false, &pole);
    if (pivot >= 0)
        tends_to_stratum(f, rq, pivot, r);
    else if (!(grows && say_rates(f, rq, apart, r)) && pole >= 0 && f->field->lost_pole < 0)
        tends_to_pole(f, pole, grows, r);
    return pivot >= 0 || pole >= 0;
}

/* An equation that was redundant as far as this. */
static void say_given(struct flow *f, struct traj_result *r)
{
    char name[40];
    given_name(f->given, f->given->lost, name, sizeof name);
    snprintf(r->ended_detail, sizeof r->ended_detail, "beyond this time the motion would not satisfy %s, which was found to follow from the other equations "
             "where the motion began: give trajectory.initial beyond to see what they say there", name);
    r->ended_error += r->ended_error > 0 ? given_late(f->given, r->ended_t) : 0;
}

/* Whether the motion was refused beyond its end because of a given equation. */
static bool given_ended(const struct flow *f, const struct traj_request *rq, const struct traj_result *r)
{
    double way = rq->times[rq->samples - 1] - rq->start;
    return f->given->lost >= 0 && fabs(f->given->lost_t - r->ended_t) <= 1e-3 * fabs(way);
}

/* A jump that only what is differentiated could take up. */
static bool say_impulse(struct flow *f, struct traj_result *r)
{
    double t = r->ended_t, jump;
    int constraint;
    if (!impulse_at_end(f, &t, &constraint, &jump))
        return false;
    char *text = expr_text(f->sys->store, f->given->sol->constraint[constraint].expr, 120);
    r->ended_reason = "impulse";
    r->ended_t = t;
    snprintf(r->ended_detail, sizeof r->ended_detail, "the constraint %s = 0 jumps by %.6g here, and what it holds is differentiated: it would have to jump, by an impulse", text, jump);
    free(text);
    return true;
}

/* A jump of what is differentiated that the equations leave open. */
static bool say_undecided(const struct flow *f, const struct traj_request *rq, struct traj_result *r)
{
    double way = rq->times[rq->samples - 1] - rq->start;
    if (!f->leap || !(fabs(f->leap->undecided_t - r->ended_t) <= 1e-9 * fabs(way)))
        return false;
    snprintf(r->ended_detail, sizeof r->ended_detail, "the constraints jump here, and by how much what is differentiated jumps depends on how they do: the equations do not say it");
    return true;
}

/* What has no value beyond the end. */
static bool say_valued(const struct flow *f, const struct traj_request *rq, struct traj_result *r)
{
    double way = rq->times[rq->samples - 1] - rq->start;
    if (f->lost_value < 0 || !(fabs(f->lost_value_t - r->ended_t) <= 1e-3 * fabs(way)))
        return false;
    SGA_FREED char *text = expr_text(f->sys->store, rq->valued[f->lost_value], 120);
    snprintf(r->ended_detail, sizeof r->ended_detail, "beyond this time %s has no value, which one of the equations is solved for a variable by", text);
    return true;
}

/* The end of a function's domain: one that the motion would be back from within a step, or (ahead) that it has come to. */
static bool say_border(struct flow *f, const struct traj_request *rq, bool ahead, struct traj_result *r)
{
    static const double SAME = 1e-6;
    struct field *field = f->field;
    double near = SAME * fabs(r->ended_t - rq->start);
    int border = field->border >= 0 && fabs(field->border_t - r->ended_t) <= near ? field->border : -1;
    if (border < 0 && ahead)
        border = field_border_ahead(field, r->ended_t, fmax(near, r->ended_error));
    if (border < 0)
        return false;
    SGA_FREED char *text = expr_text(f->sys->store, field->guard_expr[border], 120);
    r->ended_reason = "left_domain";
    snprintf(r->ended_detail, sizeof r->ended_detail, "beyond this time %s is negative, and a function in the equations has no value there", text);
    return true;
}

static bool by_numbers(enum ode_reason reason)
{
    return reason == ODE_CONSTRAINT_LOST || reason == ODE_LEFT_DOMAIN || reason == ODE_NOT_SMOOTH || reason == ODE_BLOW_UP || reason == ODE_STEP_LIMIT;
}

/* Nothing but roundings keeps points from the constraints, or steps from their tolerance. */
static bool say_rounded(struct flow *f, struct traj_result *r)
{
    double lost = strcmp(r->arithmetic, "double") ? 0 : charts_lost(f);
    r->rounded = lost > ROUNDED;
    if (r->rounded)
        snprintf(r->ended_detail, sizeof r->ended_detail, "the roundings of double grow to %.1g in the equations here, more than the tolerances allow: "
                 "ask for the arithmetic \"double-double\", or for larger tolerances", lost);
    return r->rounded;
}

/* The solution has not grown by far where derivatives do. */
static bool stays_small(const struct flow *f, const struct traj_result *r)
{
    static const double FAR = 1e3;
    double first = 1, last = 0;
    for (int j = 0; j < f->n; j++) {
        first = fmax(first, fabs(r->initial[j]));
        last = fmax(last, fabs(f->field->home[j]));
    }
    return last <= FAR * first;
}

/* Endings that the field, its pivots, its denominators or the given equations explain. */
static void explain(struct flow *f, const struct traj_request *rq, enum ode_reason reason, struct traj_result *r)
{
    if ((reason == ODE_CONSTRAINT_LOST || reason == ODE_LEFT_DOMAIN) && (say_undecided(f, rq, r) || say_impulse(f, r)))
        return;
    if (f->field->fell >= 0 && reason != ODE_SINGULAR && by_numbers(reason) && fabs(f->field->fell_t - r->ended_t) <= ENDINGS_NEAR * fabs(r->ended_t - rq->start)) {
        f->field->lost_pivot = f->field->fell;       /* what numbers have come to beside it is no reason of its own */
        field_fall_refine(f->field);
        r->ended_t = f->field->fell_t;
        if (!endings_far(f, rq, r))
            say_rank(f, rq, r);
        return;
    }
    if (reason == ODE_CONSTRAINT_LOST && given_ended(f, rq, r)) {
        say_given(f, r);
        return;
    }
    if ((reason == ODE_CONSTRAINT_LOST || reason == ODE_NOT_SMOOTH) && say_rounded(f, r))
        return;
    if ((reason == ODE_LEFT_DOMAIN || reason == ODE_NOT_SMOOTH) && say_border(f, rq, false, r))
        return;
    if (reason == ODE_LEFT_DOMAIN && say_valued(f, rq, r))
        return;
    if (reason == ODE_SINGULAR) {
        if (!endings_far(f, rq, r) && !say_steep(f, rq, r))
            say_rank(f, rq, r);
    } else if (reason == ODE_LEFT_DOMAIN && f->field->lost_pole >= 0)
        say_pole(f, false, "is 0 here", r);
    else if (reason == ODE_LEFT_DOMAIN || reason == ODE_CONSTRAINT_LOST || reason == ODE_NOT_SMOOTH) {
        if (!look_for_stratum(f, rq, false, r) && reason == ODE_LEFT_DOMAIN)
            say_border(f, rq, true, r);
    }
    else if (reason == ODE_BLOW_UP) {
        if (f->field->lost_pole < 0 && stays_small(f, r) && say_border(f, rq, true, r))      /* s = log(x) is x' = .. up to the edge, as s' = log(x) is */
            return;
        if (f->field->lost_pole >= 0)
            say_pole(f, true, "is 0 here", r);
        if (!endings_far(f, rq, r))
            look_for_stratum(f, rq, true, r);
    }
}

/* Where a zero tells the time, how far that is from where the steps ended is sure to be no less than its error. */
void traj_explain_end(struct flow *f, const struct traj_request *rq, enum ode_reason reason, struct traj_result *r)
{
    double t = r->ended_t;
    explain(f, rq, reason, r);
    r->ended_error += r->ended_error > 0 ? fabs(r->ended_t - t) : 0;
}

bool ended_by_pivots(const struct traj_result *r)
{
    static const char *const reason[] = { "stratum", "constraint_lost", "left_domain", "blow_up", "not_smooth", "singular", "step_limit" };
    bool may = false;
    for (size_t k = 0; k < sizeof reason / sizeof *reason && r->ended && r->ended_event < 0; k++)
        may |= strcmp(r->ended_reason, reason[k]) == 0;
    return may;
}
