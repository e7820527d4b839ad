/* The global error by other solutions, and refinement until it is small enough.
 *
 * Two solutions at tolerances apart by a factor of ten differ by the error of the looser
 * one. Errors follow tolerances only roughly (over a few steps they scatter by several
 * times), hence the factors below; what both may have alike inside a step is added (inside.c); a test holds them against closed forms and against
 * references of 20 digits and more. Where a companion tells the difference (companion.h) the looser one is not computed. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "larger.h"
#include "march.h"
#include "budget.h"
#include "companion.h"
#include "mem.h"
#include "tolerance.h"

/* The comparison solution is at least this much looser than the one delivered. */
#define LOOSER 10.0
#define LOOSEST 100.0
/* For the scatter: the delivered solution's error is estimated by this times the
 * difference, and where the looser one is looser by more than LOOSER, by SURE over that. */
#define ALLOWANCE 1.5
/* Where rounding may stand in for the error, the two solutions have part of it in common (that of the constants). */
#define ROUNDING_ALLOWANCE 4.0
#define SURE 30.0
/* The same by a companion, whose steps leave out two terms more (companion.h). */
#define BESIDE 1.0
/* Roundings of the field that the factors above allow for. */
#define QUIET 4.0
#define TIGHTEST_RTOL 1e-14
/* Below this rounding may stand in for the error, which then follows no tolerance. */
#define ROUNDING_RTOL 0.99e-12
#define MOST_SOLUTIONS 7
/* Of the size of what differs: roundings that no difference shows, and what the iterations of implicit steps leave in both (radau_newton.c: some
 * hundredths of 1e-13 a step). */
#define GRAIN (4 * DBL_EPSILON)
#define IMPLICIT_GRAIN (64 * DBL_EPSILON)
struct pair {
    const struct ode_run *run;
    int columns;
    double factor;             /* of the difference */
    double *a, *b, *inside, *raw;      /* columns each; count */
    double *each;              /* count x columns */
};

static void outputs(const struct pair *q, double t, const double *x, double *y)
{
    const struct ode_problem *p = q->run->p;
    if (p->output)
        p->output(p->ctx, t, x, y);
    else
        memcpy(y, x, (size_t)p->n * sizeof *y);
}

/* Estimates of sample k; *worst is raised to the largest in units of what was asked for. A
 * difference cannot show a few roundings of the size of what it is of. */
static double sample_error(struct pair *q, const struct ode_result *r, const struct ode_result *other, int k, double *worst)
{
    const struct ode_run *run = q->run;
    size_t at = (size_t)k * (size_t)r->n;
    assert(k < other->count || other->happened > 0);
    double most = 0, t = run->start->times[k], grain = r->stats.implicit_steps ? IMPLICIT_GRAIN : GRAIN;
    outputs(q, t, r->samples + at, q->a);
    if (k < other->count)
        outputs(q, t, other->samples + at, q->b);
    else      /* it stopped shortly before, at an event */
        outputs(q, other->end.t, other->happened_x + (size_t)(other->happened - 1) * (size_t)r->n, q->b);
    ode_inside(run, r, k, q->a, q->inside);
    const struct sga_tolerance asked = { run->o.rtol, run->o.atol };
    for (int j = 0; j < q->columns; j++) {
        double unit = !run->p->output ? run->unit[j] : run->o.output_unit ? run->o.output_unit[j] : 1;
        double e = q->factor * fabs(q->a[j] - q->b[j]) + q->inside[j] + grain * fabs(q->a[j]);
        e = isnan(e) ? INFINITY : e;
        most = sga_larger(most, e);
        q->each[(size_t)k * (size_t)q->columns + (size_t)j] = e;
        if (!run->o.output_beside || !run->o.output_beside[j])
            *worst = sga_larger(*worst, sga_error_ratio(e, asked, unit, q->a[j]));
    }
    return most;
}

/* Two solutions went through the same events? What is touched at one tolerance may be missed or passed at another. Those of different functions
 * that happen at once have no order of their own: each function's are compared, of[i] is the place in b of the i-th in a. NULL: they are not the same. */
static int *paired(const struct ode_result *a, const struct ode_result *b, int events)
{
    int count = a->happened, *of = sga_malloc(((size_t)count + 1) * sizeof *of);
    SGA_FREED int *first = sga_malloc(((size_t)events + (size_t)b->happened + 1) * sizeof *first);
    int *next = first + events;
    for (int e = 0; e < events; e++)
        first[e] = -1;
    for (int i = b->happened - 1; i >= 0; i--) {
        assert(b->happening[i].event < events);
        next[i] = first[b->happening[i].event];
        first[b->happening[i].event] = i;
    }
    bool same = count == b->happened;
    for (int i = 0; i < count && same; i++) {
        int *at = first + a->happening[i].event;
        of[i] = *at;
        same = of[i] >= 0 && b->happening[of[i]].crossing == a->happening[i].crossing;
        *at = same ? next[of[i]] : -1;
    }
    if (same)
        return of;
    free(of);
    return NULL;
}

/* Of the times of event i; 0 where there is none. */
static double difference(const struct ode_result *a, const struct ode_result *b, const int *of, int i)
{
    return i >= 0 && i < a->happened ? fabs(a->happening[i].t - b->happening[of[i]].t) : 0;
}

/* What the solutions differ by at sample k, as a difference of the time of event i: its function has that slope. */
static double difference_beside(const struct ode_run *run, const struct ode_result *a, const struct ode_result *b, int i, int k, double *g)
{
    const struct ode_happening *h = a->happening + i;
    size_t n = (size_t)a->n;
    if (h->slope == 0 || k < 0 || k >= a->count || k >= b->count)
        return 0;
    SGA_FREED double *y = sga_malloc((n + 1) * sizeof *y);
    const double *x = a->happened_x + (size_t)i * n;
    run->p->event(run->p->ctx, h->t, x, g);
    double at = g[h->event];
    for (size_t j = 0; j < n; j++)
        y[j] = x[j] + (a->samples[(size_t)k * n + j] - b->samples[(size_t)k * n + j]);
    run->p->event(run->p->ctx, h->t, y, g);
    double off = fabs((g[h->event] - at) / h->slope);
    return isfinite(off) ? off : 0;
}

/* Of the times of events. A difference can pass through 0 here too: what is beside are other events, and samples. A touch has no time as sharp as the
 * tolerances. */
static void event_errors(const struct ode_run *run, double factor, struct ode_result *res, const struct ode_result *other, const int *of)
{
    const struct sga_tolerance asked = { run->o.rtol, run->o.atol };
    double time_unit = run->o.time_unit > 0 ? run->o.time_unit : 1, direction = run->start->count && run->start->times[run->start->count - 1] < run->start->t ? -1 : 1;
    SGA_FREED double *g = sga_malloc(((size_t)run->p->events + 1) * sizeof *g);
    for (int i = 0, k = 0; i < res->happened && of; i++) {
        struct ode_happening *h = res->happening + i;
        while (k < res->count && direction * (run->start->times[k] - h->t) <= 0)
            k++;
        double size = fmax(fabs(h->t), fabs(h->t - run->start->t));
        double raw = difference(res, other, of, i), near = fmax(difference(res, other, of, i - 1), difference(res, other, of, i + 1));
        near = fmax(near, fmax(difference_beside(run, res, other, i, k - 1, g), difference_beside(run, res, other, i, k, g)));
        h->error = factor * fmax(raw, fmin(near, ODE_NEIGHBOUR * raw)) + 4 * DBL_EPSILON * fmax(size, res->stats.largest_step);
        if (h->crossing)
            res->worst = fmax(res->worst, sga_error_ratio(h->error, asked, time_unit, size));
    }
}

/* Of the time at which it ends. An event's is known better than by the difference. */
static double end_error(const struct ode_run *run, const struct ode_result *res, const struct ode_result *other)
{
    if (res->end.reason == ODE_EVENT) {
        double e = res->happened ? res->happening[res->happened - 1].error : INFINITY;
        return isfinite(e) ? e : 0;
    }
    if (!ode_reason_placed(res->end.reason) || !ode_reason_placed(other->end.reason))
        return 0;
    return ode_end_error(fabs(res->end.t - other->end.t), res->rtol, res->end.t - run->start->t) + fmax(res->end.left, other->end.left) + 4 * DBL_EPSILON * fmax(fabs(res->end.t), res->stats.largest_step);
}

/* Fills error, max_error, worst. A difference can pass through 0 where the error does not:
 * each estimate is raised towards the largest of its neighbours', but not without bound,
 * because they may be far away. */
static void set_errors(const struct ode_run *run, double factor, struct ode_result *res, const struct ode_result *other)
{
    SGA_FREED int *of = paired(res, other, run->p->events);
    bool alike = of != NULL;
    int reach = other->count + (alike && other->end.reason == ODE_EVENT);
    int known = reach < res->count ? reach : res->count;
    struct pair q = {.run = run, .columns = run->p->output ? run->p->outputs : run->p->n, .factor = factor};
    q.a = sga_malloc((3 * (size_t)q.columns + 1) * sizeof *q.a);
    q.b = q.a + q.columns;
    q.inside = q.b + q.columns;
    q.raw = sga_malloc(((size_t)res->count + 1) * sizeof *q.raw);
    res->error = sga_malloc(((size_t)res->count + 1) * sizeof *res->error);
    res->column_error = q.each = sga_malloc(((size_t)res->count * (size_t)q.columns + 1) * sizeof *q.each);
    res->max_error = res->worst = 0;
    for (int k = 0; k < res->count; k++)
        q.raw[k] = k < known ? sample_error(&q, res, other, k, &res->worst) : INFINITY;
    for (int k = 0; k < res->count; k++) {
        double near = sga_larger(k > 0 ? q.raw[k - 1] : 0, k + 1 < known ? q.raw[k + 1] : 0);
        double e = sga_larger(q.raw[k], near < ODE_NEIGHBOUR * q.raw[k] ? near : ODE_NEIGHBOUR * q.raw[k]);
        res->error[k] = e;
        res->max_error = sga_larger(res->max_error, e);
        for (int j = 0; j < q.columns; j++) {
            double *own = q.each + (size_t)k * (size_t)q.columns + (size_t)j;
            *own = k >= known ? INFINITY : q.raw[k] > 0 && isfinite(q.raw[k]) ? *own * (e / q.raw[k]) : *own;
        }
    }
    event_errors(run, factor, res, other, of);
    res->end.error = end_error(run, res, other);
    res->end.alone = res->end.reason == ODE_BLOW_UP && other->end.reason == ODE_NONE;
    if (known < res->count || !alike || res->end.alone)
        res->worst = INFINITY;
    free(q.a);
    free(q.raw);
}

static void add_stats(struct ode_stats *sum, const struct ode_stats *s)
{
    sum->steps += s->steps;
    sum->refused += s->refused;
    sum->evaluations += s->evaluations;
    sum->projections += s->projections;
    sum->jacobians += s->jacobians;
    sum->factorisations += s->factorisations;
    sum->implicit_steps += s->implicit_steps;
    sum->kinks += s->kinks;
    sum->stiff_steps += s->stiff_steps;
}

/* A loose solution is given up, the tight one takes its place. */
static void replace(struct ode_result *res, struct ode_result *next)
{
    add_stats(&next->second, &res->second);
    add_stats(&next->second, &res->stats);
    next->solutions = res->solutions + 1;
    ode_result_free(res);
    *res = *next;
}

/* The tolerances of the first of two solutions; where the second could not be had in
 * double precision, looser ones. */
static double first_rtol(double rtol, double atol)
{
    return atol <= rtol && rtol < LOOSER * TIGHTEST_RTOL ? LOOSER * TIGHTEST_RTOL : rtol;
}

/* How much tighter the next solution has to be; 0: that cannot be had. */
static double next_ratio(const struct ode_result *res, const struct ode_options *now)
{
    double most = now->rtol > 0 ? now->rtol / TIGHTEST_RTOL : LOOSEST;
    double ratio = fmin(fmin(LOOSEST, fmax(LOOSER, 0.5 * res->worst)), most);
    return ratio >= 0.5 * LOOSER ? ratio : 0;
}

static bool out_of_budget(const struct ode_result *r)
{
    return r->end.reason == ODE_TIME_LIMIT || r->end.reason == ODE_CANCELLED;
}

/* One solution, the first, third, ... of those that are compared late. */
static void march(const struct ode_run *next, struct ode_result *res)
{
    struct ode_start late;
    struct ode_run here = *next;
    bool shifted = next->level % 2 == 0 && ode_late_start(next, &late);
    if (shifted)
        here.start = &late;
    ode_march(&here, res);
    if (shifted)
        free((double *)late.times);
}

/* The errors of a solution by its companion. */
static void set_errors_beside(const struct ode_run *run, struct ode_result *res)
{
    struct ode_result other = *res;
    assert(res->apart && !res->happened);
    other.samples = res->apart;
    for (size_t i = 0; i < (size_t)res->count * (size_t)res->n; i++)
        other.samples[i] = res->samples[i] - res->apart[i];
    set_errors(run, BESIDE, res, &other);
    free(res->apart);
    res->apart = NULL;
}

/* With a companion where the one before had one. */
static void march_tighter(struct ode_run *next, double ratio, struct ode_result *tight)
{
    assert(ratio >= 0.5 * LOOSER);       /* solutions nearer to each other say nothing of their errors */
    next->o.rtol /= ratio;
    next->o.atol /= ratio;
    next->level++;
    next->accompanied &= next->o.rtol >= ROUNDING_RTOL;
    march(next, tight);
}

/* Another solution after *res, which is `ratio` tighter, takes its place. False, with shortfall set: *res stays. */
static bool tighten(const struct ode_run *run, struct ode_run *next, double ratio, struct ode_result *res, struct ode_result tight)
{
    double before = res->worst;
    if (tight.count < res->count && (out_of_budget(&tight) || tight.end.reason == ODE_STEP_LIMIT)) {
        res->shortfall = out_of_budget(&tight) ? "the time granted ended before a tighter solution was found"
                                               : "a tighter solution takes more steps than are allowed";
        add_stats(&res->second, &tight.stats);
        res->solutions++;
        ode_result_free(&tight);
        return false;
    }
    if (tight.apart && (tight.end.reason == ODE_NONE || tight.end.reason == ODE_TIME_LIMIT)) {
        set_errors_beside(run, &tight);
        replace(res, &tight);
        return true;
    }
    set_errors(run, ALLOWANCE, &tight, res);
    /* where the differences fall as they should, the delivered error is smaller still */
    bool falls = before > 0 && tight.worst < 0.3 * before, rounding = next->o.rtol < ROUNDING_RTOL;
    if (rounding ? !falls : falls && ratio > LOOSER) {
        free(tight.error);
        free(tight.column_error);
        set_errors(run, rounding ? ROUNDING_ALLOWANCE : fmin(ALLOWANCE, SURE / ratio), &tight, res);
    }
    struct ode_end end = res->end;     /* before it no sample is lost, and a tighter solution meets its roundings sooner: they say nothing of the end */
    bool sooner = tight.end.reason == ODE_CONSTRAINT_LOST && tight.count == res->count
                  && (end.t - tight.end.t) * (tight.end.t - run->start->t) > 0;
    end.error = tight.end.error;
    replace(res, &tight);
    if (sooner)
        res->end = end;
    return true;
}

static const char *why_not(const struct ode_result *res)
{
    return isinf(res->worst) ? "the solutions that were compared do not end at the same time, or not with the same events; "
                               "errors past the earlier end are not known"
                             : "rounding in double precision, as the motion amplifies it, exceeds the tolerance";
}

/* Where the solution grows without bound, the last samples may be nothing but error. */
static void drop_lost(struct ode_result *res)
{
    while (res->end.reason == ODE_BLOW_UP && res->count > 1 && res->error) {
        const double *x = res->samples + (size_t)(res->count - 1) * (size_t)res->n;
        double size = 0;
        for (int j = 0; j < res->n; j++)
            size = fmax(size, fabs(x[j]));
        if (res->error[res->count - 1] < 0.1 * size)
            break;
        res->count--;
    }
    res->max_error = res->error && res->end.reason == ODE_BLOW_UP ? 0 : res->max_error;
    for (int k = 0; k < res->count && res->end.reason == ODE_BLOW_UP && res->error; k++)
        res->max_error = fmax(res->max_error, res->error[k]);
}

/* n: by how many roundings the field may be wrong, where these are more than a few; else NULL. */
static double *noise_of(const struct ode_run *run)
{
    const struct ode_problem *p = run->p;
    double *noise = sga_malloc(((size_t)p->n + 1) * sizeof *noise), most = 0;
    bool known = p->noise && p->noise(p->ctx, run->start->t, run->start->x, noise);
    for (int j = 0; j < p->n && known; j++)
        most = sga_larger(most, noise[j]);
    if (most > QUIET)
        return noise;
    free(noise);
    return NULL;
}

/* Of the time left, where rows are to be kept: for the first of two solutions. The second, which is tighter, has the rest. */
static const double FIRST_PART = 0.45;

static void march_first(struct ode_run *next, struct ode_result *res)
{
    const struct sga_budget *all = next->o.budget;
    struct sga_budget part;
    if (next->o.keep_rows && all && all->deadline > 0) {
        double now = sga_now();
        part = *all;
        part.deadline = now + FIRST_PART * fmax(all->deadline - now, 0);
        next->o.budget = &part;
    }
    march(next, res);
    next->o.budget = all;
}

/* Events beyond t are not told. */
static void drop_events(const struct ode_run *run, double t, struct ode_result *res)
{
    double direction = t < run->start->t ? -1 : 1;
    while (res->happened > 0 && direction * (res->happening[res->happened - 1].t - t) > 0)
        res->happened--;
}

/* The time for the first solution ended: its samples are solved once more, tighter. As many as that reaches are kept, with their errors. */
static void keep_rows(const struct ode_run *run, struct ode_run *next, struct ode_result *res)
{
    struct ode_start part = *run->start;
    struct ode_end end = res->end;
    struct ode_result tight;
    part.count = res->count;
    next->start = &part;
    next->o.rtol /= LOOSER;
    next->o.atol /= LOOSER;
    next->level++;
    march(next, &tight);
    end.t = tight.count > 0 ? part.times[tight.count - 1] : run->start->t;
    if (tight.end.reason == ODE_NONE || tight.end.reason == ODE_TIME_LIMIT) {
        drop_events(run, end.t, &tight);
        drop_events(run, end.t, res);
        tight.end = end;
    }
    set_errors(run, ALLOWANCE, &tight, res);
    replace(res, &tight);
    if (res->worst > 1)
        res->shortfall = "the time granted ended before a tighter solution was found";
}

/* An end of whose time so much of the way is not known may be one of loose steps alone (a rate that grows with the square of what they missed). */
static bool is_vague(const struct ode_run *run, const struct ode_result *res)
{
    static const double VAGUE = 0.1;
    return ode_reason_placed(res->end.reason) && res->end.error > VAGUE * fabs(res->end.t - run->start->t);
}

/* Of an end of whose time as much as that of the way there is not known nothing is. */
static bool is_lost(const struct ode_run *run, const struct ode_result *res)
{
    enum ode_reason r = res->end.reason;
    if (res->end.alone)
        return true;
    return ode_reason_placed(r) && r != ODE_EVENT && r != ODE_CONSTRAINT_LOST && ode_time_is_lost(res->end.error, res->end.t - run->start->t);
}

/* Tighter solutions, until errors are as small as was asked for, and ends are known. */
static void refine(const struct ode_run *run, struct ode_run *next, struct ode_result *res)
{
    while ((res->worst > 1 || is_vague(run, res)) && run->o.refine && !out_of_budget(res)) {
        struct ode_result tight;
        double before = res->worst, ratio = next_ratio(res, &next->o);
        if (res->solutions >= MOST_SOLUTIONS || ratio == 0) {
            res->shortfall = res->worst > 1 ? why_not(res) : NULL;
            return;
        }
        march_tighter(next, ratio, &tight);
        if (!tighten(run, next, ratio, res, tight))
            return;
        if (!(res->worst < 0.9 * before) && next->o.rtol < ROUNDING_RTOL) {
            res->shortfall = res->worst > 1 ? why_not(res) : NULL;
            return;
        }
    }
    if (res->worst > 1)
        res->shortfall = out_of_budget(res) ? "the time granted ended before a tighter solution was found" : "no tighter solution was asked for";
}

/* What is known of a loose solution's error, which is all there is: nothing. */
static void no_errors(const struct ode_run *run, struct ode_result *res)
{
    size_t each = (size_t)res->count * (size_t)(run->p->output ? run->p->outputs : run->p->n);
    res->error = sga_malloc(((size_t)res->count + 1) * sizeof *res->error);
    res->column_error = sga_malloc((each + 1) * sizeof *res->column_error);
    for (int k = 0; k < res->count; k++)
        res->error[k] = INFINITY;
    for (size_t k = 0; k < each; k++)
        res->column_error[k] = INFINITY;
    res->max_error = res->worst = INFINITY;
}

/* The tighter of two solutions first: where its companion says what its error is the looser one is not needed. *ready: it is made, and is for
 * comparison. True: done. */
static bool global_beside(const struct ode_run *run, struct ode_run *next, struct ode_result *res, bool *ready)
{
    *ready = next->o.rtol / LOOSER >= ROUNDING_RTOL && ode_companion_may(run);
    if (!*ready)
        return false;
    next->accompanied = true;
    march_tighter(next, LOOSER, res);
    bool rows = run->o.keep_rows && res->end.reason == ODE_TIME_LIMIT && res->count > 0;
    if (run->o.keep_rows && !res->apart && out_of_budget(res)) {       /* given up: two others, as far as these come */
        *ready = false;
        ode_result_free(res);
        return false;
    }
    if (out_of_budget(res) && !rows)
        return true;
    if (!res->apart || !(res->end.reason == ODE_NONE || rows))
        return false;
    set_errors_beside(run, res);
    refine(run, next, res);
    return true;
}

static void global(const struct ode_run *run, const double *noise, struct ode_result *res)
{
    struct ode_run next = *run, tighter;
    struct ode_result tight;
    bool ready;
    next.o.rtol = first_rtol(run->o.rtol, run->o.atol);
    next.noise = noise;
    tighter = next;
    if (global_beside(run, &tighter, &tight, &ready)) {
        *res = tight;
        return;
    }
    next.beside = true;
    march_first(&next, res);
    next.beside = false;
    next.noise = NULL;
    if (out_of_budget(res)) {
        if (ready)
            ode_result_free(&tight);
        if (run->o.keep_rows && res->end.reason == ODE_TIME_LIMIT && res->count > 0)
            keep_rows(run, &next, res);
        return;
    }
    if (res->end.reason != ODE_NONE && res->end.reason != ODE_EVENT) {       /* perhaps only because it ran beside the motion */
        struct ode_result again;
        march(&next, &again);
        replace(res, &again);
    }
    res->worst = 0;
    if (ready)
        next = tighter;
    else
        march_tighter(&next, LOOSER, &tight);
    next.accompanied = false;
    if (tighten(run, &next, LOOSER, res, tight))
        refine(run, &next, res);
    else
        no_errors(run, res);
}

void ode_global(const struct ode_run *run, struct ode_result *res)
{
    double *noise = noise_of(run);
    global(run, noise, res);
    free(noise);
    if (is_lost(run, res))
        ode_end_by_errors(&res->end);
    if (!(res->worst <= 1) || res->end.reason == ODE_TOLERANCE)        /* what is known of samples before it is less than was asked for: ends that agree say nothing then */
        res->end.error = 0;
    drop_lost(res);
}
