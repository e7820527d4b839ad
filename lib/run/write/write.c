/* The result object, member by member. */
#include "tradeoff.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ask.h"
#include "run_job.h"
#include "job_texts.h"
#include "print.h"
#include "reduce.h"
#include "reduction.h"
#include "request.h"
#include "slice.h"
#include "stage_clock.h"
#include "structure.h"
#include "warnings.h"
#include "watch.h"
#include "write.h"

void answer_write_variables(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "variables");
    size_t start = w->out->len;
    sga_json_array(w);
    for (int i = 0; i < j->request->system.variables; i++) {
        sga_json_object(w);
        sga_json_member_string(w, "name", answer_variable_name(j, i));
        sga_json_member_string(w, "role", j->request->system.variable[i].role);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
    if (j->request->families == REQUEST_FAMILIES_FOLD)        /* others are named by these: unless asked for they stay */
        answer_fold(j, w, start);
}

/* General points contradict the system: the functions that vanish where it is solved. */
static void write_where(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "where");
    expr_json_list(&j->request->store, j->solution->special, j->solution->specials, 4000, w);
}

static void write_dimensions(const struct job *j, struct sga_json *w)
{
    const struct sga_solution *sol = j->solution;
    int n = j->request->system.variables;
    sga_json_key(w, "dimensions");
    sga_json_object(w);
    sga_json_member_int(w, "ambient", n);
    sga_json_key(w, "generations");
    sga_json_array(w);
    for (int k = 0; k < sol->generations; k++)
        sga_json_int(w, sol->dimension[k]);
    sga_json_end_array(w);
    sga_json_key(w, "final");
    if (sol->verdict == SGA_INCONSISTENT)
        sga_json_null(w);
    else
        sga_json_int(w, n - sol->constraints);
    sga_json_end_object(w);
}

/* -1: not known, or the solution is not unique. A system that is solved where some functions vanish only is another one. */
static int differentiation_index(struct job *j)
{
    const struct sga_solution *sol = j->solution;
    if ((sol->verdict != SGA_UNIQUE && sol->verdict != SGA_ISOLATED) || sol->specials)
        return -1;
    if (j->request->system.square)
        return sol->generations;
    return j->op ? -1 : structure_index(&j->request->system, sol, j->oracle, j->budget);
}

static void write_index(struct job *j, struct sga_json *w)
{
    const struct sga_solution *sol = j->solution;
    int differentiation = differentiation_index(j);
    sga_json_key(w, "index");
    sga_json_object(w);
    sga_json_member_int(w, "generations", sol->generations);
    sga_json_key(w, "differentiation");
    if (differentiation >= 0)
        sga_json_int(w, differentiation);
    else
        sga_json_null(w);
    sga_json_member_int(w, "seed", sol->generations > 0 ? sol->generations - 1 : 0);
    if (j->op) {
        sga_json_key(w, "operator");
        if (answer_operator_index(j) < 0)
            sga_json_null(w);
        else
            sga_json_int(w, answer_operator_index(j));
    }
    sga_json_end_object(w);
}

static void write_definitions(const struct job *j, struct sga_json *w)
{
    if (!j->texts || !j->texts->names.count)
        return;
    sga_json_key(w, "definitions");
    sga_json_array(w);
    for (int i = 0; i < j->texts->names.count; i++) {
        sga_json_object(w);
        sga_json_member_string(w, "name", j->texts->names.name[i]);
        sga_json_member_string(w, "expression", j->texts->names.text[i]);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_constraints(const struct job *j, struct sga_json *w)
{
    assert(j->solution->constraints <= j->texts->names.roots);
    sga_json_key(w, "constraints");
    size_t start = w->out->len;
    sga_json_array(w);
    for (int i = 0; i < j->solution->constraints; i++) {
        sga_json_object(w);
        sga_json_member_int(w, "generation", j->solution->constraint[i].generation);
        sga_json_member_string(w, "expression", j->texts->names.root[i]);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
    answer_fold(j, w, start);
}

/* {variable: text} for a field whose texts start at root `first`; zeros are left out if sparse */
static void write_components(const struct job *j, struct sga_json *w, int first, bool sparse)
{
    assert(first >= 0 && first + j->request->system.variables <= j->texts->names.roots);
    size_t start = w->out->len;
    sga_json_object(w);
    for (int i = 0; i < j->request->system.variables; i++) {
        const char *text = j->texts->names.root[first + i];
        if (sparse && strcmp(text, "0") == 0)
            continue;
        sga_json_key(w, answer_variable_name(j, i));
        sga_json_string(w, text);
    }
    sga_json_end_object(w);
    answer_fold(j, w, start);
}

static void write_field(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "vector_field");
    sga_json_object(w);
    sga_json_key(w, "components");
    write_components(j, w, j->texts->first_field, false);
    sga_json_key(w, "free");
    sga_json_array(w);
    for (int k = 0; k < j->solution->free_columns; k++) {
        char name[160];
        answer_free_name(j, k, name, sizeof name);
        sga_json_string(w, name);
    }
    sga_json_end_array(w);
    sga_json_end_object(w);
}

static void write_gauge(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "gauge");
    sga_json_object(w);
    sga_json_member_int(w, "dimension", j->solution->free_columns);
    sga_json_key(w, "fields");
    sga_json_array(w);
    for (int k = 0; k < j->solution->free_columns; k++)
        write_components(j, w, j->texts->first_gauge + k * j->request->system.variables, true);
    sga_json_end_array(w);
    sga_json_end_object(w);
}

/* Seconds of each stage that ran; the points that the reduction drew are told apart from it. */
static void write_seconds(struct job *j, struct sga_json *w)
{
    struct stage_clock *c = j->clock;
    double total = 0;
    stage_begin(c, STAGE_WRITING);
    sga_json_key(w, "seconds");
    sga_json_object(w);
    for (int k = 0; k < STAGES; k++) {
        double sampling = k == STAGE_REDUCTION ? fmin(c->sampling, c->seconds[k]) : 0;
        total += c->seconds[k];
        if (c->seconds[k] > 0)
            sga_json_member_double(w, stage_text((enum stage)k), c->seconds[k] - sampling);
        if (sampling > 0)
            sga_json_member_double(w, "sampling", sampling);
    }
    sga_json_member_double(w, "total", total);
    sga_json_end_object(w);
}

/* The amount of work, the same on every machine. */
static void write_counts(struct sga_json *w)
{
    sga_json_key(w, "counts");
    sga_json_object(w);
    sga_json_member_int(w, "balls", sga_watch_counted(SGA_COUNT_BALLS));
    sga_json_member_int(w, "modular", sga_watch_counted(SGA_COUNT_MODULAR));
    sga_json_member_int(w, "polynomial_terms", sga_watch_counted(SGA_COUNT_TERMS));
    sga_json_end_object(w);
}

static void write_work(struct job *j, struct sga_json *w)
{
    sga_json_key(w, "work");
    sga_json_object(w);
    write_seconds(j, w);
    write_counts(w);
    sga_json_member_int(w, "nodes", j->request->store.nodes);
    sga_json_member_int(w, "pivots", j->solution->pivots);
    sga_json_member_int(w, "variables_modelled", j->request->system.variables);
    sga_json_member_int(w, "variables", j->slice ? j->slice->variables : j->request->system.variables);
    const struct traj_result *motion = j->part ? j->part->trajectory : j->trajectory;
    if (j->part)
        sga_json_member_int(w, "variables_moved", j->part->request->system.variables);
    if (motion) {
        sga_json_member_int(w, "steps", motion->steps);
        sga_json_member_int(w, "rejected_steps", motion->rejected);
        sga_json_member_int(w, "evaluations", motion->evaluations);
    }
    sga_json_end_object(w);
}

void answer_write_reduction(struct job *j, struct sga_json *w)
{
    unsigned want = j->request->want;
    bool solvable = j->solution->verdict != SGA_INCONSISTENT;
    sga_json_member_string(w, "verdict", sga_verdict_text(j->solution->verdict));
    write_dimensions(j, w);
    write_index(j, w);
    write_definitions(j, w);
    if (want & REQUEST_CONSTRAINTS)
        write_constraints(j, w);
    if (want & REQUEST_VECTOR_FIELD && solvable)
        write_field(j, w);
    if (want & REQUEST_GAUGE && solvable)
        write_gauge(j, w);
}

/* What was had of a motion, of the job that made it. */
static bool write_motion(struct job *j, struct sga_json *w)
{
    if (j->initial)
        answer_write_initial(j, w);
    if (j->sweep) {
        sga_json_key(w, "trajectories");
        answer_raw(j, w, j->sweep);
    }
    if (j->trajectory && !answer_write_trajectory(j, w))
        return false;
    if (j->tradeoff)
        answer_write_tradeoff(j, w);
    return true;
}

bool answer_write(struct job *j, struct sga_buf *out)
{
    assert(j->solution && j->oracle);
    struct sga_json json, *w = &json;
    unsigned want = j->request->want;
    bool solvable = j->solution->verdict != SGA_INCONSISTENT;
    stage_begin(j->clock, STAGE_WRITING);
    sga_json_begin(w, out);
    sga_json_object(w);
    sga_json_member_string(w, "verdict", sga_verdict_text(j->solution->verdict));
    if (j->solution->verdict == SGA_ISOLATED) {
        sga_json_key(w, "equilibrium");
        if (j->solution->equilibrium < 0)
            sga_json_null(w);
        else
            sga_json_bool(w, j->solution->equilibrium);
    }
    if (j->request->name) {
        sga_json_member_string(w, "name", j->request->name);
    }
    answer_write_variables(j, w);
    if (j->solution->specials)
        write_where(j, w);
    write_dimensions(j, w);
    answer_write_tables(j, w);
    if (want & REQUEST_INDEX)
        write_index(j, w);
    write_definitions(j, w);
    if (want & REQUEST_CONSTRAINTS)
        write_constraints(j, w);
    if (want & REQUEST_VECTOR_FIELD && solvable)
        write_field(j, w);
    if (want & REQUEST_GAUGE && solvable)
        write_gauge(j, w);
    answer_write_modes(j, w);
    answer_write_strata(j, w);
    if (j->op)
        answer_write_operator(j, w);
    if (j->mechanical)
        answer_write_mechanical(j, w);
    if (want & REQUEST_STRUCTURE) {
        sga_json_key(w, "structure");
        sga_json_object(w);
        sga_json_key(w, "kronecker");
        sga_json_raw(w, j->kronecker, strlen(j->kronecker));
        if (j->structure)
            answer_write_structure(j, w);
        sga_json_end_object(w);
    }
    if (j->kronecker_is_linear) {
        sga_json_key(w, "kronecker");
        sga_json_raw(w, j->kronecker, strlen(j->kronecker));
    }
    if (want & REQUEST_SYMMETRIES)
        answer_write_symmetries(j, w);
    if (!write_motion(j->part ? j->part : j, w))
        return false;
    if (j->sets) {
        sga_json_key(w, "sets");
        answer_raw(j, w, j->sets);
    }
    if (j->fit) {
        sga_json_key(w, "fit");
        sga_json_raw(w, j->fit, strlen(j->fit));
    }
    if (j->ask && j->ask->linearization.len) {
        sga_json_key(w, "linearization");
        sga_json_raw(w, j->ask->linearization.data, j->ask->linearization.len);
    }
    if (j->ask && j->ask->transfer.len) {
        sga_json_key(w, "transfer");
        sga_json_raw(w, j->ask->transfer.data, j->ask->transfer.len);
    }
    if (j->ask && j->ask->equilibria.len) {
        sga_json_key(w, "equilibria");
        sga_json_raw(w, j->ask->equilibria.data, j->ask->equilibria.len);
    }
    if (j->ask && j->ask->derivation.len) {
        sga_json_key(w, "derivation");
        sga_json_raw(w, j->ask->derivation.data, j->ask->derivation.len);
    }
    if (j->ask && j->ask->dirac.len) {
        sga_json_key(w, "dirac");
        sga_json_raw(w, j->ask->dirac.data, j->ask->dirac.len);
    }
    answer_write_evidence(j, w);
    answer_warn(j);
    sga_json_key(w, "warnings");
    sga_warnings_write(j->warnings, w);
    write_work(j, w);
    sga_json_end_object(w);
    return answer_fits(j, out);
}
