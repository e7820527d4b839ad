/* A system whose parameters are symbols, reduced for general values of them. */
#include "vary_model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "derive.h"
#include "error.h"
#include "events_of.h"
#include "texts.h"
#include "guess.h"
#include "jet.h"
#include "mem.h"
#include "operator_answer.h"
#include "reduce.h"
#include "seeds.h"
#include "stage_clock.h"
#include "start_of.h"
#include "system.h"
#include "table.h"
#include "variation.h"
#include "warnings.h"

/* Down to this the automatic choice is double. */
static const double DOUBLE_SUFFICES = 1e-9;

static bool has_operator(const struct job *j) { return j->request->op.has; }
static bool has_mechanical(const struct job *j) { return j->request->mechanical; }

static const struct job_stage model_stages[] = {
    { "operator",   -1, false, has_operator,   answer_operator,          answer_operator_clear },
    { "mechanical", -1, false, has_mechanical, answer_mechanical,        answer_mechanical_clear },
    { "reduction",  -1, false, NULL,           answer_reduce,            answer_reduce_clear },
    { "sga",        -1, false, has_mechanical, answer_mechanical_motion, NULL },
    { 0 },
};

static const struct job_stage mode_stages[] = {
    { "operator",   -1, false, has_operator,   answer_operator,          answer_operator_clear },
    { "mechanical", -1, false, has_mechanical, answer_mechanical,        answer_mechanical_clear },
    { "reduction",  -1, false, NULL,           answer_reduce,            answer_reduce_clear },
    { "sga",        -1, false, has_mechanical, answer_mechanical_motion, NULL },
    { "texts",      -1, false, NULL,           answer_texts,             answer_texts_clear },
    { "witness",    -1, false, NULL,           answer_witness,           answer_witness_clear },
    { 0 },
};

/* Where the reduction is to look: the request's start, at the parameters' values. */
static bool set_near(struct job *j)
{
    const struct request *r = j->request;
    const struct sys_system *s = &r->system;
    const struct request_trajectory *t = &r->trajectory;
    j->start.time = t->start;
    j->start.parameter = sga_zeros(&j->mem, (size_t)s->parameters + 1, sizeof *j->start.parameter);
    for (int k = 0; k < s->parameters; k++) {
        const struct expr_symbol *p = s->store->symbol + s->parameter[k];
        j->start.parameter[k] = p->table ? expr_table_value(p->table, p->order, t->start) : NAN;
        for (int i = 0; i < r->swept_count; i++)
            if (r->swept[i].symbol == s->parameter[k] && r->swept[i].value && !variation_constants(s->store, &r->swept[i].value, 1, j->start.parameter + k))
                return false;
    }
    j->start.x = sga_zeros(&j->mem, (size_t)s->variables + 1, sizeof *j->start.x);
    j->start.given = sga_zeros(&j->mem, (size_t)s->variables + 1, 1);
    for (int k = 0; k < t->initials; k++) {
        j->start.x[t->initial[k].variable] = t->initial[k].value;
        j->start.given[t->initial[k].variable] = 1;
    }
    guess_complete(s, j->start.given, j->start.time, j->start.parameter, j->start.x);
    return true;
}

/* The reduction once more, with gauge conditions as equations without derivatives. */
static bool with_conditions(struct vary_model *m)
{
    struct job *j = &m->job;
    const struct request_trajectory *t = &m->request.trajectory;
    for (int k = 0; k < t->conditions; k++) {
        char source[64];
        snprintf(source, sizeof source, "trajectory.gauge.conditions[%d]", k);
        sys_add_row(&m->request.system, t->condition[k], source);
    }
    struct reduction_options options = { .near = j->start.x, .near_given = j->start.given, .near_time = j->start.time, .parameter_near = j->start.parameter, .seed = SGA_SEED_MOTION,
                                         .budget = j->budget, .gauge_fields = true, .gauge_nodes = answer_gauge_nodes(j) };
    points_oracle_init(&m->oracle, 20250102);
    m->has_conditioned = true;
    m->solution = &m->conditioned;
    return sga_reduce(&m->request.system, &options, &m->oracle, &m->conditioned, j->err);
}

static void set_request(struct vary_model *m)
{
    struct job *j = &m->job;
    struct request *r = &m->request;
    const struct request_trajectory *t = &r->trajectory;
    size_t n = (size_t)r->system.variables;
    double *initial = sga_zeros(&j->mem, n + 1, sizeof *initial);
    unsigned char *given = sga_zeros(&j->mem, n + 1, 1), *held = sga_zeros(&j->mem, n + 1, 1);
    expr_id *exact = sga_zeros(&j->mem, n + 1, sizeof *exact);
    struct traj_rate *rate = sga_zeros(&j->mem, (size_t)t->rates + 1, sizeof *rate);
    for (int k = 0; k < t->initials; k++) {
        int v = t->initial[k].variable;
        initial[v] = t->initial[k].value;
        exact[v] = t->initial[k].open ? t->initial[k].open : t->initial[k].exact;
        given[v] = 1;
    }
    for (int k = 0; k < t->holds; k++)
        held[t->hold[k]] = 1;
    for (int k = 0; k < t->rates; k++)
        rate[k] = (struct traj_rate){ t->rate[k].variable, t->rate[k].rate };
    m->rq = (struct traj_request){
        .start = t->start, .times = t->times, .samples = t->samples, .initial = initial, .given = given, .held = held, .rate = rate, .rates = t->rates,
        .conditions = t->conditions > 0, .output = t->output, .outputs = t->outputs, .rtol = r->accuracy.rtol, .atol = r->accuracy.atol,
        .own_atol = r->accuracy.own_atol, .method = r->accuracy.method, .arithmetic = (enum traj_arithmetic)r->accuracy.arithmetic, .budget = j->budget,
        .exact_start = t->exact_start, .exact_initial = exact,
    };
    answer_start_of(r, &j->mem, &m->rq);
    if (m->rq.arithmetic == TRAJ_DOUBLE_DOUBLE || m->rq.arithmetic == TRAJ_BALL || (m->rq.arithmetic == TRAJ_AUTO && m->rq.rtol < DOUBLE_SUFFICES)) {
        expr_id *time = sga_zeros(&j->mem, (size_t)t->samples + 1, sizeof *time);
        for (int k = 0; k < t->samples; k++)
            time[k] = request_exact_time(r, k);
        m->rq.exact_time = time;
    }
}

static void model_job(struct vary_model *m, struct job *of, const struct job_stage *stages)
{
    struct job *j = &m->job;
    *j = (struct job){ .request = &m->request, .request_text = of->request_text, .request_length = of->request_length, .host = of->host, .stages = stages,
                       .err = of->err, .stage = of->stage };
    j->host.progress = NULL;
    j->clock = sga_zeros(&j->mem, 1, sizeof *j->clock);
    j->warnings = sga_zeros(&j->mem, 1, sizeof *j->warnings);
    j->budget = sga_zeros(&j->mem, 1, sizeof *j->budget);
    *j->budget = *of->budget;
    j->budget->warnings = j->warnings;
    m->request.store.deadline = of->request->store.deadline;
    m->request.store.seconds = of->request->store.seconds;
    m->request.want = REQUEST_TRAJECTORY;
}

static bool reduce(struct vary_model *m, struct job *of)
{
    struct job *j = &m->job;
    model_job(m, of, model_stages);
    if (!set_near(j) || !job_run(j, false))
        return false;
    m->solution = j->solution;
    return !m->request.trajectory.conditions || with_conditions(m);
}

bool vary_model_make(struct vary_model *m, struct job *j, const struct request_open *open, int opens, const char *pointer)
{
    *m = (struct vary_model){ 0 };
    if (j->request->op.has && opens)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, pointer, "the form operator needs the values of its parameters; write the equations in the form \"equations\" to differentiate by them");
    if (!request_read_open(&m->request, j->request_text, j->request_length, open, opens, j->err)) {
        snprintf(j->err->pointer, sizeof j->err->pointer, "%s", pointer);
        return false;
    }
    m->read = true;
    m->programs = num_jet_programs_new();
    if (!reduce(m, j)) {
        if (!j->err->pointer[0])
            snprintf(j->err->pointer, sizeof j->err->pointer, "%s", pointer);
        return j->err->code == SGA_E_OK ? sga_fail_at(j->err, SGA_E_EXPR_UNDEFINED, pointer, "a parameter has no finite value") : false;
    }
    if (m->solution->verdict == SGA_INCONSISTENT)
        return sga_fail_at(j->err, SGA_E_NO_MOTION, pointer, "for general values of these parameters the system is inconsistent (%.300s): it has motions at special values only, by which "
                           "nothing can be differentiated", m->solution->contradiction_why);
    set_request(m);
    if (events_set_any(&m->request)) {
        m->rq.event = events_of(&m->request, &m->job.mem);
        m->rq.events = m->request.trajectory.events;
        m->rq.mass = masses_of(&m->job, &m->job.mem);
    }
    return true;
}

bool vary_model_mode(struct vary_model *m, struct job *of, const struct vary_mode *mode)
{
    static const unsigned told = REQUEST_CONSTRAINTS | REQUEST_INDEX | REQUEST_VECTOR_FIELD | REQUEST_GAUGE;
    struct job *j = &m->job;
    *m = (struct vary_model){ 0 };
    if (!request_read_modes(&m->request, of->request_text, of->request_length, &(struct request_choice){ mode->choice, mode->open, mode->opens }, of->err))
        return false;
    m->read = true;
    m->programs = mode->opens ? num_jet_programs_new() : NULL;
    model_job(m, of, mode->opens ? model_stages : mode_stages);
    j->budget->warnings = mode->opens ? j->warnings : of->warnings;      /* told once already */
    m->request.want |= mode->opens ? 0 : of->request->want & told;
    if (!set_near(j))
        return sga_fail_at(j->err, SGA_E_EXPR_UNDEFINED, "/system/parameters", "a parameter has no finite value");
    const struct sys_system *s = &m->request.system, *from = mode->from;
    for (int k = 0; k < from->variables; k++) {
        const char *name = from->store->symbol[from->variable[k].symbol].name;
        for (int v = 0, symbol = expr_symbol_find(s->store, name, strlen(name)); v < s->variables && symbol >= 0; v++)
            if (s->variable[v].symbol == symbol) {
                j->start.x[v] = mode->x[k];
                j->start.given[v] = 1;
            }
    }
    j->start.time = mode->t;
    if (!job_run(j, false))
        return false;
    m->solution = j->solution;
    set_request(m);
    return true;
}

static int variable_of(const struct sys_system *s, int symbol)
{
    for (int k = 0; k < s->variables; k++)
        if (s->variable[k].symbol == symbol)
            return k;
    return -1;
}

bool vary_model_columns(struct vary_model *m, const struct sys_system *start, const char *text, struct sga_error *err)
{
    const struct sys_system *s = &m->request.system;
    if (m->rq.outputs)
        return true;
    expr_id *output = sga_zeros(&m->job.mem, (size_t)start->variables + 1, sizeof *output);
    for (int k = 0; k < start->variables; k++) {
        const char *name = start->store->symbol[start->variable[k].symbol].name;
        int symbol = expr_symbol_find(s->store, name, strlen(name));
        if (symbol < 0 || variable_of(s, symbol) < 0)
            return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/outputs", "with %s there is no variable %.100s, which is a column where the motion starts; name columns that all modes have in outputs",
                               text, name);
        output[k] = s->store->symbol[symbol].node;
    }
    m->rq.output = output;
    m->rq.outputs = start->variables;
    return true;
}

void vary_model_clear(struct vary_model *m)
{
    if (m->has_conditioned) {
        points_oracle_clear(&m->oracle);
        sga_solution_clear(&m->conditioned);
    }
    if (m->job.stages)
        job_clear(&m->job);
    if (m->read)
        request_clear(&m->request);
    num_jet_programs_free(m->programs);
}

void vary_model_guess(struct vary_model *m, const struct traj_request *rq, int parameter, int variable, expr_id *to)
{
    struct expr_store *st = &m->request.store;
    for (int j = 0; j < m->request.system.variables; j++) {
        expr_id e = rq->exact_initial[j];
        to[j] = parameter >= 0 && e ? expr_diff(st, e, parameter) : expr_int(st, parameter < 0 && j == variable);
    }
}
