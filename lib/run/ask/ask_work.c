/* Where a linearization is asked for: starts and samples. */
#include "ask_work.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "budget.h"
#include "error.h"
#include "integrate.h"
#include "oracle.h"
#include "points.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "seeds.h"
#include "start_of.h"
#include "system.h"
#include "trajectory.h"
#include "warnings.h"

/* Inputs as they were named, or the variables that the form calls inputs. */
static void set_inputs(struct ask_work *s, const struct request_ports *p)
{
    const struct sys_system *sys = &s->j->request->system;
    int most = p->says_inputs ? p->inputs : sys->variables;
    struct linear_input *input = sga_zeros(&s->mem, (size_t)most + 1, sizeof *input);
    for (int k = 0; k < p->inputs; k++)
        input[s->rq.inputs++] = (struct linear_input){ p->input[k].name, p->input[k].variable, p->input[k].signal };
    for (int k = 0; k < sys->variables && !p->says_inputs; k++)
        if (strcmp(sys->variable[k].role, "input") == 0)
            input[s->rq.inputs++] = (struct linear_input){ answer_variable_name(s->j, k), k, -1 };
    s->rq.input = input;
}

void ask_begin(struct ask_work *s, struct job *j, const struct request_ports *p, struct sga_buf *out)
{
    const struct request *r = j->request;
    bool own = p->outputs > 0;
    *s = (struct ask_work){ .j = j, .rq = { .sys = &r->system, .sol = j->solution, .oracle = j->oracle, .said_in = "linearization.inputs", .output = own ? p->output : r->output,
                                            .outputs = own ? p->outputs : r->outputs, .budget = j->budget } };
    set_inputs(s, p);
    s->ports = (struct linear_ports){ s->rq.input, s->rq.inputs, own ? p->output_text : r->output_name, s->rq.outputs, NULL };
    sga_json_begin(&s->json, out);
}

/* By a reduction whose pivots are large there: formulas whose pivots vanish at a point have no value at it, whatever they are of. */
static bool with_pivots_of(struct ask_work *s, struct linearization *l, const struct linear_guess *guess)
{
    struct job *j = s->j;
    struct reduction_options options = { .near = guess->x, .near_time = guess->t, .near_pivots = true, .parameter_near = j->start.parameter, .seed = SGA_SEED_CHART,
                                         .budget = j->budget, .gauge_fields = true };
    struct sga_solution own;
    struct points_oracle oracle;
    struct sga_error ignored = { 0 };
    struct linear_request rq = s->rq;
    points_oracle_init(&oracle, SGA_SEED_CHART);
    rq.sol = &own;
    rq.oracle = &oracle;
    bool ok = sga_reduce(s->rq.sys, &options, &oracle, &own, &ignored) && sga_solution_same_kind(s->rq.sol, &own);
    if (ok) {
        linearization_clear(l);
        ok = linearize(l, &rq, guess, &ignored);
    }
    sga_solution_clear(&own);
    points_oracle_clear(&oracle);
    return ok;
}

bool ask_linearize(struct ask_work *s, struct linearization *l, const struct linear_guess *guess, struct sga_error *err)
{
    if (linearize(l, &s->rq, guess, err))
        return true;
    if ((err->code != SGA_E_UNDECIDED && err->code != SGA_E_EXPR_UNDEFINED) || !sga_budget_ok(s->rq.budget, NULL) || !with_pivots_of(s, l, guess))
        return false;
    *err = (struct sga_error){ 0 };
    return true;
}

/* At a point of the final set. */
static bool at_point(struct ask_work *s, const struct linear_guess *guess, bool anywhere)
{
    struct job *j = s->j;
    struct linearization l;
    bool ok = ask_linearize(s, &l, guess, j->err) && s->take(s, &l, anywhere);
    linearization_clear(&l);
    return ok && job_goes_on(j) && answer_fits(j, s->json.out);
}

static void give(struct ask_work *s, const struct request_initial *initial, int count, struct traj_request *r, expr_id *exact)
{
    int n = s->j->request->system.variables;
    double *x = sga_zeros(&s->mem, (size_t)n + 1, sizeof *x);
    unsigned char *given = sga_zeros(&s->mem, (size_t)n + 1, 1);
    for (int k = 0; k < count; k++) {
        x[initial[k].variable] = initial[k].value;
        given[initial[k].variable] = 1;
        exact[initial[k].variable] = initial[k].exact;
    }
    r->initial = x;
    r->given = given;
}

/* The motion's part of the request: where it starts, and how exactly. */
static struct traj_request motion(struct ask_work *s, double start, bool own_start)
{
    const struct job *j = s->j;
    const struct request_trajectory *t = &j->request->trajectory;
    unsigned char *held = sga_zeros(&s->mem, (size_t)j->request->system.variables + 1, 1);
    for (int k = 0; k < t->holds; k++)
        held[t->hold[k]] = 1;
    struct traj_request r = {
        .start = start, .held = held, .rtol = j->request->accuracy.rtol, .atol = j->request->accuracy.atol, .own_atol = j->request->accuracy.own_atol,
        .on = j->oracle->reals && j->oracle->real[0].variables == j->request->system.variables ? j->oracle->real[0].x : NULL,
        .method = j->request->accuracy.method, .arithmetic = TRAJ_DOUBLE, .budget = j->budget };
    if (own_start)
        answer_start_of(j->request, &s->mem, &r);
    return r;
}

static bool at_values(struct ask_work *s, double time, const struct request_initial *initial, int count, bool anywhere, bool start_too)
{
    struct job *j = s->j;
    struct traj_request r = motion(s, time, start_too);
    struct traj_initial start;
    expr_id *exact = sga_zeros(&s->mem, (size_t)j->request->system.variables + 1, sizeof *exact);
    give(s, initial, count, &r, exact);
    if (!traj_consistent(&j->request->system, j->solution, &r, &start, j->err)) {
        if (!j->err->pointer[0])
            snprintf(j->err->pointer, sizeof j->err->pointer, "%s", start_too ? "/trajectory/initial" : "/linearization/at");
        return false;
    }
    struct linear_guess guess = { .x = start.x, .t = time, .exact = exact, .budget = j->budget };
    bool ok = at_point(s, &guess, anywhere);
    traj_initial_clear(&start);
    return ok;
}

bool ask_at_values(struct ask_work *s, double time, const struct request_initial *initial, int count, bool anywhere)
{
    return at_values(s, time, initial, count, anywhere, false);
}

static bool at_rows(struct ask_work *s, const struct traj_result *rows)
{
    int n = s->j->request->system.variables;
    bool ok = true;
    assert(rows->columns == n);
    for (int k = 0; k < rows->rows && ok; k++) {
        struct linear_guess guess = { .x = rows->value + (size_t)k * (size_t)n, .t = rows->t[k], .budget = s->j->budget };
        ok = at_point(s, &guess, false);
    }
    return ok;
}

/* Along the motion that the answer gives, or, where that has outputs for columns, along the same once more. */
bool ask_at_samples(struct ask_work *s)
{
    struct job *j = s->j;
    const struct request_trajectory *t = &j->request->trajectory;
    if (j->trajectory && !t->outputs)
        return at_rows(s, j->trajectory);
    struct traj_request r = motion(s, t->start, true);
    struct traj_result rows;
    struct traj_rate *rate = sga_zeros(&s->mem, (size_t)t->rates + 1, sizeof *rate);
    expr_id *exact = sga_zeros(&s->mem, (size_t)j->request->system.variables + 1, sizeof *exact);
    give(s, t->initial, t->initials, &r, exact);
    for (int k = 0; k < t->rates; k++)
        rate[k] = (struct traj_rate){ t->rate[k].variable, t->rate[k].rate };
    r.rate = rate;
    r.rates = t->rates;
    r.times = t->times;
    r.samples = t->samples;
    if (!answer_integrate(j, j->solution, &r, &rows, j->err))
        return false;
    bool ok = at_rows(s, &rows);
    if (ok && rows.ended)
        sga_warn(j->budget, SGA_W_LIST_CUT, "/linearization/at", "the motion ends at %.10g (%.200s): %d of %d samples come before it", rows.ended_t, rows.ended_detail, rows.rows, t->samples);
    traj_result_clear(&rows);
    return ok;
}

bool ask_at_start(struct ask_work *s)
{
    const struct request_trajectory *t = &s->j->request->trajectory;
    return at_values(s, t->start, t->initial, t->initials, !t->has, true);
}

bool ask_is_free(const struct job *j, int k)
{
    const struct sga_solution *sol = j->solution;
    bool is = false;
    for (int g = 0; g < sol->free_columns && sol->gauge; g++)
        is |= !expr_is_zero(&j->request->store, sol->gauge[(size_t)g * (size_t)j->request->system.variables + (size_t)k]);
    return is;
}

void ask_drop_determined(struct ask_work *s)
{
    struct linear_input *input = (struct linear_input *)s->rq.input;
    int kept = 0;
    for (int k = 0; k < s->rq.inputs; k++)
        if (input[k].variable < 0 || ask_is_free(s->j, input[k].variable))
            input[kept++] = input[k];
    assert(kept <= s->rq.inputs);
    s->rq.inputs = s->ports.inputs = kept;
}

bool ask_possible(struct job *j)
{
    if (j->solution->verdict == SGA_INCONSISTENT)
        return sga_fail_at(j->err, SGA_E_NO_MOTION, "/want", "the system is inconsistent: no point satisfies it, so there is nothing to ask of its motion; leave `linearization`, `transfer` and `equilibria` out of want to see why");
    if (j->request->op.open_sources)
        return sga_fail_at(j->err, SGA_E_NO_MOTION, "/system/sources", "what is asked of the motion needs each source as a function of time");
    return true;
}
