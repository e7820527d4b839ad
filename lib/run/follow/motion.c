/* From the reduction to numbers: consistent start, trajectory, gauge conditions. */
#include "run_job.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "events_of.h"
#include "follow.h"
#include "integrate.h"
#include "mem.h"
#include "modes.h"
#include "oracle.h"
#include "points.h"
#include "reduction.h"
#include "request.h"
#include "seeds.h"
#include "slides.h"
#include "stage_clock.h"
#include "start_of.h"
#include "sweep.h"
#include "system.h"
#include "tradeoff.h"

/* Of the time gone: ends of a motion that are one. */
static const double SAME_END = 1e-9;
/* Down to this the automatic choice is double, and stays it. */
static const double DOUBLE_SUFFICES = 1e-9;

/* Gauge conditions are equations without derivatives: with them the same reduction is run
 * once more, and what it leaves is integrated. */
static bool with_conditions(struct job *j, struct sga_solution *solution, struct points_oracle *oracle)
{
    const struct request_trajectory *t = &j->request->trajectory;
    for (int k = 0; k < t->conditions; k++) {
        char source[64];
        snprintf(source, sizeof source, "trajectory.gauge.conditions[%d]", k);
        sys_add_row(&j->request->system, t->condition[k], source);
    }
    struct reduction_options options = { .near = j->start.x, .near_given = j->start.given, .near_time = j->start.time, .parameter_near = j->start.parameter, .seed = SGA_SEED_MOTION, .budget = j->budget,
                                   .gauge_fields = j->request->want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF) || t->relations, .gauge_nodes = answer_gauge_nodes(j) };
    points_oracle_init(oracle, 20250102);
    if (!sga_reduce(&j->request->system, &options, oracle, solution, j->err)) {
        snprintf(j->err->pointer, sizeof j->err->pointer, "/trajectory/gauge/conditions");
        return false;
    }
    if (solution->verdict == SGA_INCONSISTENT && !j->request->swept_count)
        return sga_fail_at(j->err, SGA_E_GAUGE, "/trajectory/gauge/conditions",
                           "the gauge conditions contradict the system: %s", solution->contradiction_why);
    return true;
}

/* What longer arithmetics start from: constants where doubles would be rounded. */
static void exact_values(struct job *j, struct traj_request *r)
{
    const struct request_trajectory *t = &j->request->trajectory;
    expr_id *initial = sga_calloc((size_t)j->request->system.variables + 1, sizeof *initial);
    expr_id *time = sga_malloc((size_t)(t->samples + 1) * sizeof *time);
    for (int k = 0; k < t->initials; k++)
        initial[t->initial[k].variable] = t->initial[k].exact;
    for (int k = 0; k < t->samples; k++)
        time[k] = request_exact_time(j->request, k);
    r->exact_start = t->exact_start;
    r->exact_initial = initial;
    r->exact_time = time;
}

static bool better(const struct traj_result *next, const struct traj_result *r)
{
    return !r->rounded || !next->ended || next->rows >= r->rows;
}

/* What a motion goes through in pieces: at the most one of modes and slides is not NULL. sides: of switches, in balls. */
struct pieces { struct job *j; struct modes *modes; struct slides *slides, *sides; struct sga_arena *mem; };

static bool ends_at_switch(const struct sga_solution *solution, const struct traj_request *r, const struct traj_result *t)
{
    bool other = r->modes || r->rates || r->conditions || solution->free_columns;
    return r->arithmetic == TRAJ_BALL && t->ended && !t->out_of_time && !other && !strcmp(t->ended_reason, "not_enclosed");
}

static bool comes_further(const struct traj_request *r, const struct traj_result *next, const struct traj_result *t)
{
    if (!next->ended || next->rows != t->rows)
        return !next->ended || next->rows > t->rows;
    bool says = strcmp(next->ended_reason, "not_enclosed") != 0;     /* why the motion ends, which is more */
    double went = fabs(t->ended_t - r->start), goes = fabs(next->ended_t - r->start);
    return goes > went || (says && goes >= went * (1 - SAME_END));
}

/* In balls a motion of this system (the job's own, or that of a set of a sweep) that ends where a switch turns goes on by the sides of its switches, each a system of its own. */
static void go_by_sides(void *of, const struct sys_system *sys, const struct sga_solution *solution, const struct traj_request *r, struct traj_result *t)
{
    struct pieces *p = of;
    struct job *j = p->j;
    bool own = !j->request->sweeps;
    if (!ends_at_switch(solution, r, t) || !job_goes_on(j))
        return;
    struct traj_request sides = *r;
    struct traj_result again;
    struct sga_error ignored = { 0 };
    j->slides.in_balls = true;
    if (!p->sides && !slides_begin(j, solution, &sides, p->mem, &p->sides))
        return;
    const struct traj_request *q = own ? &sides : slides_set(p->sides, sys, solution, r, &ignored);
    bool found = q && q->modes && (own ? answer_integrate(j, solution, q, &again, &ignored) : traj_run(sys, solution, q, &again, &ignored)), further = found && comes_further(r, &again, t);
    if (found)
        traj_result_clear(further ? t : &again);
    if (further)
        *t = again;
    if (!found && ignored.code == SGA_E_NO_MOTION && t->ended_t == r->start)
        snprintf(t->ended_detail, sizeof t->ended_detail, "%.250s", ignored.detail);      /* which says more */
    j->slides.begin = own && further ? slides_begin : NULL;
    j->slides.in_balls = own && further;
}

/* Where double turns out not to suffice, exact values are made after all, and longer numbers are tried. */
static bool integrate(struct job *j, const struct sga_solution *solution, struct traj_request *r, struct pieces *pieces)
{
    j->trajectory = sga_zeros(&j->mem, 1, sizeof *j->trajectory);
    if (!answer_integrate(j, solution, r, j->trajectory, j->err)) {
        j->trajectory = NULL;
        return false;
    }
    struct traj_result *t = j->trajectory;
    go_by_sides(pieces, &j->request->system, solution, r, t);
    if (r->arithmetic == TRAJ_BALL)
        return job_goes_on(j);
    if (r->arithmetic != TRAJ_AUTO || r->exact_time || traj_in_pieces(r) || !(t->shortfall || t->rounded) || t->beside || t->out_of_time)
        return true;
    struct traj_result again;
    struct sga_error ignored = { 0 };
    exact_values(j, r);
    r->arithmetic = t->rounded ? TRAJ_DOUBLE_DOUBLE : TRAJ_AUTO;
    if (expr_store_ok(&j->request->store) && answer_integrate(j, solution, r, &again, &ignored)) {
        struct traj_result *worse = better(&again, t) ? t : &again;
        traj_result_clear(worse);
        if (worse == t)
            *t = again;
    }
    r->arithmetic = TRAJ_AUTO;
    return job_goes_on(j);
}

static bool start(struct job *j, const struct sga_solution *solution, struct traj_request *r)
{
    j->initial = sga_zeros(&j->mem, 1, sizeof *j->initial);
    if (traj_consistent(&j->request->system, solution, r, j->initial, j->err))
        return true;
    j->initial = NULL;
    return false;
}

/* A motion that is there is kept where the time for the table ends. */
static bool tradeoff(struct job *j, const struct sga_solution *solution, struct traj_request *r)
{
    if (!j->trajectory)
        return answer_tradeoff(j, solution, r);
    double deadline = job_shorten(j);
    bool ok = !j->trajectory->out_of_time && answer_tradeoff(j, solution, r);
    j->budget->deadline = deadline;
    if (ok || !job_leaves_out(j, deadline, "/want", "the tradeoff"))
        return ok;
    answer_tradeoff_clear(j->tradeoff);
    j->tradeoff = NULL;
    return true;
}

static const struct traj_request *set_pieces(void *of, int set, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err)
{
    struct pieces *p = of;
    modes_set(p->modes, set, sys, sol, rq);
    return p->slides ? slides_set(p->slides, sys, sol, rq, err) : rq;
}

static void tell_pieces(void *of)
{
    struct pieces *p = of;
    modes_tell(p->modes);
    if (p->slides)
        slides_tell(p->slides);
}

static void unset_pieces(void *of)
{
    struct pieces *p = of;
    if (p->slides)
        slides_unset(p->slides);
    if (p->sides)
        slides_unset(p->sides);
}

static bool sweep(struct job *j, const struct sga_solution *solution, struct traj_request *r, struct pieces *pieces)
{
    bool ok = answer_sweep(j, solution, r, (struct sweep_modes){ pieces, set_pieces, go_by_sides, tell_pieces, unset_pieces, pieces->modes || pieces->slides });
    if (ok && r->rows_until > 0 && sga_now() >= r->rows_until)
        job_ends(j);
    return ok;
}

static bool run(struct job *j, const struct sga_solution *solution, struct points_oracle *oracle, struct traj_request *r, struct pieces *pieces)
{
    stage_begin(j->clock, STAGE_INITIAL);
    answer_integrals(j, solution, oracle, r);
    r->on = oracle->reals && oracle->real[0].variables == j->request->system.variables ? oracle->real[0].x : NULL;
    if (j->request->want & REQUEST_CONSISTENT_INITIAL) {
        if (!start(j, solution, r))
            return false;
        j->initial_residuals = solution->constraints;
    }
    if (j->request->want & REQUEST_TRAJECTORY && j->request->sweeps)
        return sweep(j, solution, r, pieces);
    if (j->request->want & REQUEST_TRAJECTORY) {
        stage_begin(j->clock, STAGE_TRAJECTORY);
        if (!integrate(j, solution, r, pieces))
            return false;
        if (j->trajectory->out_of_time)
            job_ends(j);
    }
    return !(j->request->want & REQUEST_TRADEOFF) || tradeoff(j, solution, r);
}

/* Of the time granted: what checking and writing the rows of a motion that was cut short may take. */
static const double WRITING_PART = 0.05;

/* When motions end with the rows that they have. */
static double rows_until(const struct job *j)
{
    return j->budget->deadline > 0 ? j->budget->deadline - WRITING_PART * j->budget->seconds : 0;
}

bool answer_own_motion(struct job *j)
{
    const struct request_trajectory *t = &j->request->trajectory;
    j->slides.begin = t->sliding ? slides_begin : NULL;
    j->slides.end = slides_end;
    j->slides.in_balls = t->sliding && j->request->accuracy.arithmetic == REQUEST_BALL;
    if (!(j->request->want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF | REQUEST_CONSISTENT_INITIAL)))
        return true;
    if (j->solution->verdict == SGA_INCONSISTENT && !j->request->swept_count)
        return sga_fail_at(j->err, SGA_E_NO_MOTION, "/trajectory", "the system is inconsistent: no point satisfies it, "
                           "so there is no trajectory; leave trajectory out of want to see why");
    int n = j->request->system.variables;
    SGA_ARENA(mem);
    double *initial = sga_zeros(&mem, (size_t)n, sizeof *initial);
    unsigned char *given = sga_zeros(&mem, (size_t)n, 1), *held = sga_zeros(&mem, (size_t)n, 1);
    struct traj_rate *rate = sga_zeros(&mem, (size_t)t->rates + 1, sizeof *rate);
    for (int k = 0; k < t->initials; k++) {
        initial[t->initial[k].variable] = t->initial[k].value;
        given[t->initial[k].variable] = 1;
    }
    for (int k = 0; k < t->holds; k++)
        held[t->hold[k]] = 1;
    for (int k = 0; k < t->rates; k++)
        rate[k] = (struct traj_rate){ t->rate[k].variable, t->rate[k].rate };
    struct traj_request r = {
        .start = t->start, .times = t->times, .samples = t->samples, .initial = initial, .given = given, .held = held,
        .rate = rate, .rates = t->rates, .conditions = t->conditions > 0, .output = t->output, .outputs = t->outputs,
        .event = events_of(j->request, &mem), .events = t->events,
        .rtol = j->request->accuracy.rtol, .atol = j->request->accuracy.atol, .own_atol = j->request->accuracy.own_atol,
        .method = j->request->accuracy.method, .arithmetic = (enum traj_arithmetic)j->request->accuracy.arithmetic,
        .budget = j->budget,
    };
    r.rows_until = rows_until(j);
    answer_start_of(j->request, &mem, &r);
    bool tradeoff = j->request->want & REQUEST_TRADEOFF;
    if (t->sliding && r.arithmetic == TRAJ_AUTO)
        r.arithmetic = TRAJ_DOUBLE;      /* what pieces are followed in */
    if (r.arithmetic != TRAJ_DOUBLE && (tradeoff || r.arithmetic != TRAJ_AUTO || r.rtol < DOUBLE_SUFFICES))
        exact_values(j, &r);
    bool ok;
    struct pieces pieces = { .j = j, .modes = modes_begin(j, &r, &mem), .mem = &mem };
    if (!slides_begin(j, j->solution, &r, &mem, &pieces.slides)) {
        ok = false;
    } else if (t->conditions) {
        struct sga_solution solution = { 0 };
        struct points_oracle oracle;
        ok = with_conditions(j, &solution, &oracle) && run(j, &solution, &oracle, &r, &pieces);
        points_oracle_clear(&oracle);
        sga_solution_clear(&solution);
    } else {
        ok = run(j, j->solution, j->oracle, &r, &pieces);
    }
    modes_end(pieces.modes, ok);
    slides_end(pieces.slides, ok);
    slides_end(pieces.sides, false);
    free((expr_id *)r.exact_initial);
    free((expr_id *)r.exact_time);
    return ok;
}

bool answer_motion(struct job *j)
{
    if (j->part)
        return true;
    bool ok = answer_own_motion(j);
    const struct request_trajectory *t = &j->request->trajectory;
    if (!ok && j->err->code == SGA_E_NO_MOTION && !t->relations && !t->low && j->solution->verdict != SGA_INCONSISTENT)
        ok = answer_motion_on_stratum(j);
    return ok;
}

double answer_moved(const struct job *j, double otherwise)
{
    assert(!j->trajectory || j->trajectory->moved >= 0);
    return j->trajectory ? j->trajectory->moved : j->initial ? j->initial->moved : j->tradeoff ? j->tradeoff->moved : otherwise;
}

void answer_motion_drop(struct job *j)
{
    if (j->trajectory)
        traj_result_clear(j->trajectory);
    if (j->initial)
        traj_initial_clear(j->initial);
    answer_tradeoff_clear(j->tradeoff);
    j->trajectory = NULL;
    j->initial = NULL;
    j->tradeoff = NULL;
}

void answer_motion_clear(struct job *j)
{
    answer_motion_drop(j);
    free(j->sweep);
}
