/* The result object, member by member. */
#include "answer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "poly.h"

static const char *symbol_name(const struct job *j, int variable)
{
    return j->request.store.symbol[j->request.system.variable[variable].symbol].name;
}

/* Free functions are called f1, f2, ...; a name of the request is never used again. */
static void free_name(const struct job *j, int k, char *out, size_t size)
{
    const struct expr_store *st = &j->request.store;
    snprintf(out, size, "f%d", k + 1);
    while (expr_symbol_find(st, out, strlen(out)) >= 0) {
        size_t n = strlen(out);
        if (n + 2 > size)
            return;
        out[n] = '_';
        out[n + 1] = 0;
    }
}

static void write_variables(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "variables");
    sga_json_array(w);
    for (int i = 0; i < j->request.system.variables; i++) {
        sga_json_object(w);
        sga_json_member_string(w, "name", symbol_name(j, i));
        sga_json_member_string(w, "role", j->request.system.variable[i].role);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

/* General points contradict the system: the functions that vanish where it is solved. */
static void write_where(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "where");
    sga_json_array(w);
    for (int i = 0; i < j->solution.specials; i++) {
        struct sga_buf text = { 0 };
        if (expr_print(&j->request.store, j->solution.special[i], 4000, &text))
            sga_json_string(w, text.data);
        sga_buf_free(&text);
    }
    sga_json_end_array(w);
}

static void write_dimensions(const struct job *j, struct sga_json *w)
{
    const struct sga_solution *sol = &j->solution;
    int n = j->request.system.variables;
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

static void write_index(const struct job *j, struct sga_json *w)
{
    const struct sga_solution *sol = &j->solution;
    bool standard = (sol->verdict == SGA_UNIQUE || sol->verdict == SGA_ISOLATED) && j->request.system.square && !sol->specials;
    sga_json_key(w, "index");
    sga_json_object(w);
    sga_json_member_int(w, "generations", sol->generations);
    sga_json_key(w, "differentiation");
    if (standard)
        sga_json_int(w, sol->generations);
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
    if (!j->texts.count)
        return;
    sga_json_key(w, "definitions");
    sga_json_array(w);
    for (int i = 0; i < j->texts.count; i++) {
        sga_json_object(w);
        sga_json_member_string(w, "name", j->texts.name[i]);
        sga_json_member_string(w, "expression", j->texts.text[i]);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_constraints(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "constraints");
    sga_json_array(w);
    for (int i = 0; i < j->solution.constraints; i++) {
        sga_json_object(w);
        sga_json_member_int(w, "generation", j->solution.constraint[i].generation);
        sga_json_member_string(w, "expression", j->texts.root[i]);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

/* {variable: text} for a field whose texts start at root `first`; zeros are left out if sparse */
static void write_components(const struct job *j, struct sga_json *w, int first, bool sparse)
{
    sga_json_object(w);
    for (int i = 0; i < j->request.system.variables; i++) {
        const char *text = j->texts.root[first + i];
        if (sparse && strcmp(text, "0") == 0)
            continue;
        sga_json_key(w, symbol_name(j, i));
        sga_json_string(w, text);
    }
    sga_json_end_object(w);
}

static void write_field(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "vector_field");
    sga_json_object(w);
    sga_json_key(w, "components");
    write_components(j, w, j->first_field, false);
    sga_json_key(w, "free");
    sga_json_array(w);
    for (int k = 0; k < j->solution.free_columns; k++) {
        char name[160];
        free_name(j, k, name, sizeof name);
        sga_json_string(w, name);
    }
    sga_json_end_array(w);
    sga_json_end_object(w);
}

static void write_gauge(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "gauge");
    sga_json_object(w);
    sga_json_member_int(w, "dimension", j->solution.free_columns);
    sga_json_key(w, "fields");
    sga_json_array(w);
    for (int k = 0; k < j->solution.free_columns; k++)
        write_components(j, w, j->first_gauge + k * j->request.system.variables, true);
    sga_json_end_array(w);
    sga_json_end_object(w);
}

/* The factor of a part. The tangency is that of the constraint as it is printed. */
static expr_id printed_factor(struct job *j, const struct sga_part *part)
{
    struct poly_limits limits = { .max_terms = 80, .budget = &j->budget };
    expr_id scale = part->row < 0 && j->scale ? j->scale[part->tangency] : EXPR_UNDEF, e = part->factor;
    if (scale) {
        e = expr_mul(&j->request.store, e, scale);
        poly_normal(&j->request.store, e, &limits, &e);
    }
    return e;
}

static void write_parts(struct job *j, struct sga_json *w, const struct sga_part *part, int parts)
{
    sga_json_array(w);
    for (int k = 0; k < parts; k++) {
        struct sga_buf text = { 0 };
        sga_json_object(w);
        if (part[k].row >= 0) {
            sga_json_member_string(w, "equation", j->request.system.row[part[k].row].source);
        } else {
            sga_json_member_int(w, "tangency_of", part[k].tangency);
        }
        sga_json_key(w, "factor");
        if (expr_print(&j->request.store, printed_factor(j, part + k), 400, &text))
            sga_json_string(w, text.data);
        else
            sga_json_null(w);
        sga_json_end_object(w);
        sga_buf_free(&text);
    }
    sga_json_end_array(w);
}

/* What was divided by: every pivot that is not a number, assumed not to vanish. */
static void write_pivots(struct job *j, struct sga_json *w)
{
    enum { MOST = 200 };
    const struct sga_solution *sol = &j->solution;
    int written = 0;
    sga_json_key(w, "pivots");
    sga_json_array(w);
    for (int q = 0; q < sol->pivots && written < MOST; q++) {
        struct sga_buf text = { 0 };
        if (expr_is_const(&j->request.store, sol->pivot[q].value))
            continue;
        sga_json_object(w);
        if (sol->pivot[q].col >= 0) {       /* else a factor dropped from a constraint */
            sga_json_member_string(w, "velocity_of", symbol_name(j, sol->pivot[q].col));
        }
        sga_json_member_int(w, "generation", sol->pivot[q].generation);
        sga_json_key(w, "assumed_not_zero");
        if (expr_print(&j->request.store, sol->pivot[q].value, 400, &text))
            sga_json_string(w, text.data);
        else
            sga_json_null(w);
        sga_json_key(w, "basis");
        struct points_decision d = points_shadow_zero(&j->shadow, sol->pivot[q].value);
        sga_json_string(w, points_basis_text(d.basis));
        sga_json_end_object(w);
        sga_buf_free(&text);
        written++;
    }
    sga_json_end_array(w);
}

/* What was found to vanish on the present set, and what that rests on. */
static void write_zeros(struct job *j, struct sga_json *w)
{
    sga_json_key(w, "zeros");
    sga_json_array(w);
    for (int i = 0; i < j->shadow.zeros; i++) {
        const struct points_zero *z = j->shadow.zero + i;
        struct sga_buf text = { 0 };
        sga_json_object(w);
        sga_json_key(w, "expression");
        if (expr_print(&j->request.store, z->expr, 400, &text))
            sga_json_string(w, text.data);
        else
            sga_json_null(w);
        sga_json_member_string(w, "basis", points_basis_text(z->decision.basis));
        sga_json_member_int(w, "digits", z->decision.digits);
        sga_json_member_int(w, "real_points", z->decision.points);
        sga_json_member_int(w, "modular_points", z->decision.modular);
        sga_json_end_object(w);
        sga_buf_free(&text);
    }
    sga_json_end_array(w);
}

/* What would have to vanish, and what it was made of. */
static void write_contradiction(struct job *j, struct sga_json *w, const char *member)
{
    const struct sga_solution *sol = &j->solution;
    struct sga_buf text = { 0 };
    sga_json_key(w, member);
    sga_json_object(w);
    sga_json_key(w, "expression");
    if (sol->contradiction && expr_print(&j->request.store, sol->contradiction, 4000, &text))
        sga_json_string(w, text.data);
    else
        sga_json_null(w);
    sga_json_member_string(w, "why", sol->contradiction_why);
    sga_json_key(w, "combination");
    write_parts(j, w, sol->contradiction_part, sol->contradiction_parts);
    sga_json_end_object(w);
    sga_buf_free(&text);
}

static void write_evidence(struct job *j, struct sga_json *w)
{
    const struct sga_solution *sol = &j->solution;
    sga_json_key(w, "evidence");
    sga_json_object(w);
    sga_json_key(w, "decisions");
    sga_json_object(w);
    for (int k = 0; k < POINTS_BASES; k++) {
        sga_json_key(w, points_basis_text((enum points_basis)k));
        sga_json_int(w, j->shadow.count[k]);
    }
    sga_json_member_int(w, "real_points", j->shadow.reals);
    sga_json_key(w, "real_points_certified");
    int certified = 0;
    for (int k = 0; k < j->shadow.reals; k++)
        certified += j->shadow.real[k].certified;
    sga_json_int(w, certified);
    sga_json_member_int(w, "modular_points", j->shadow.modulars);
    if (j->shadow.count[POINTS_ZERO_NUMERIC]) {
        sga_json_member_int(w, "least_digits", j->shadow.least_digits);
    }
    sga_json_end_object(w);
    sga_json_key(w, "constraints");
    sga_json_array(w);
    for (int i = 0; i < sol->constraints; i++) {
        const struct sga_constraint *c = sol->constraint + i;
        sga_json_object(w);
        sga_json_member_int(w, "generation", c->generation);
        sga_json_member_string(w, "from", c->origin == SGA_FROM_RESTRICTION ? "restriction" : "combination");
        sga_json_key(w, "combination");
        write_parts(j, w, c->part, c->parts);
        if (c->replaced) {
            struct sga_buf text = { 0 };
            if (expr_print(&j->request.store, c->replaced, 1000, &text)) {
                sga_json_member_string(w, "in_place_of", text.data);
            }
            if (c->near_point)        /* its other zeros, if any, were not looked for */
                sga_json_member_bool(w, "near_point_only", true);
            sga_buf_free(&text);
        }
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
    if (j->has_texts && sol->verdict != SGA_INCONSISTENT)
        write_pivots(j, w);
    if (j->has_texts)
        write_zeros(j, w);
    if (sol->verdict == SGA_INCONSISTENT)
        write_contradiction(j, w, "contradiction");
    answer_write_empty_strata(j, w);
    if (sol->specials)
        write_contradiction(j, w, "contradiction_at_general_points");
    if (sol->sides) {             /* what the answer holds for */
        sga_json_key(w, "sides");
        sga_json_array(w);
        for (int i = 0; i < sol->sides; i++) {
            struct sga_buf text = { 0 };
            sga_json_object(w);
            sga_json_key(w, "function");
            if (expr_print(&j->request.store, sol->side[i].function, 1000, &text))
                sga_json_string(w, text.data);
            else
                sga_json_null(w);
            sga_json_member_string(w, "sign", sol->side[i].sign > 0 ? "positive" : "negative");
            sga_json_end_object(w);
            sga_buf_free(&text);
        }
        sga_json_end_array(w);
    }
    if (sol->not_factored) {      /* a branch may have gone unseen */
        sga_json_member_bool(w, "factors_not_searched", true);
    }
    if (sol->dense_blocks) {      /* their zeros are not among the strata */
        sga_json_member_int(w, "determinants_assumed_not_zero", sol->dense_blocks);
    }
    sga_json_member_int(w, "redundant_equations", sol->redundant_rows);
    answer_write_restrictions(j, w);
    if (j->witnessed) {
        sga_json_key(w, "witness");
        sga_json_object(w);
        sga_json_member_int(w, "points", j->witness.points);
        sga_json_member_bool(w, "certified", j->witness.certified);
        sga_json_member_int(w, "digits", j->witness.digits);
        sga_json_member_string(w, "checked", sol->verdict == SGA_INCONSISTENT ? "the contradiction at points of the earlier constraints"
                           : j->has_texts ? "the printed expressions, read back" : "the expressions");
        sga_json_end_object(w);
    }
    sga_json_end_object(w);
}

static void write_work(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "work");
    sga_json_object(w);
    sga_json_key(w, "seconds");
    sga_json_object(w);
    sga_json_member_double(w, "read", j->seconds.read);
    sga_json_member_double(w, "reduction", j->seconds.reduce);
    sga_json_member_double(w, "sampling", j->shadow.seconds_sampling);
    if (j->op)
        sga_json_member_double(w, "operator", j->seconds.operator_form);
    if (j->mechanical)
        sga_json_member_double(w, "mechanical", j->seconds.mechanical);
    if (j->has_texts) {
        sga_json_member_double(w, "print", j->seconds.print);
    }
    if (j->witnessed) {
        sga_json_member_double(w, "witness", j->seconds.witness);
    }
    if (j->has_trajectory) {
        sga_json_member_double(w, "trajectory", j->seconds.trajectory);
    }
    if (j->has_structure) {
        sga_json_member_double(w, "structure", j->seconds.structure);
    }
    if (j->symmetries.has) {
        sga_json_member_double(w, "symmetries", j->seconds.symmetries);
    }
    sga_json_end_object(w);
    sga_json_member_int(w, "nodes", j->request.store.nodes);
    sga_json_member_int(w, "pivots", j->solution.pivots);
    sga_json_member_int(w, "variables_modelled", j->request.system.variables);
    if (j->has_trajectory) {
        sga_json_member_int(w, "steps", j->trajectory.steps);
        sga_json_member_int(w, "rejected_steps", j->trajectory.rejected);
        sga_json_member_int(w, "evaluations", j->trajectory.evaluations);
    }
    sga_json_end_object(w);
}

size_t answer_limit(const struct job *j)
{
    return j->options && j->options->max_result ? j->options->max_result : (size_t)1 << 30;
}

bool answer_fits(struct job *j, const struct sga_buf *out)
{
    size_t limit = answer_limit(j);
    if (out->len <= limit)
        return true;
    return sga_fail(j->err, SGA_E_LIMIT_RESULT, "the result has more than %.1f MB (%.1f MB were written); ask for fewer samples, "
                    "or for less in want", (double)limit * 0x1p-20, (double)out->len * 0x1p-20);
}

bool answer_write(struct job *j, struct sga_buf *out)
{
    struct sga_json json, *w = &json;
    unsigned want = j->request.want;
    bool solvable = j->solution.verdict != SGA_INCONSISTENT;
    sga_json_begin(w, out);
    sga_json_object(w);
    sga_json_member_string(w, "verdict", sga_verdict_text(j->solution.verdict));
    if (j->solution.verdict == SGA_ISOLATED) {
        /* T_m Pf = 0, so the reduction asked alpha(m) = 0: the points are constant solutions */
        sga_json_member_bool(w, "equilibrium", true);
    }
    if (j->request.name) {
        sga_json_member_string(w, "name", j->request.name);
    }
    write_variables(j, w);
    if (j->solution.specials)
        write_where(j, w);
    write_dimensions(j, w);
    if (want & REQUEST_INDEX)
        write_index(j, w);
    write_definitions(j, w);
    if (want & REQUEST_CONSTRAINTS)
        write_constraints(j, w);
    if (want & REQUEST_VECTOR_FIELD && solvable)
        write_field(j, w);
    if (want & REQUEST_GAUGE && solvable)
        write_gauge(j, w);
    answer_write_strata(j, w);
    if (j->op)
        answer_write_operator(j, w);
    if (j->mechanical)
        answer_write_mechanical(j, w);
    if (want & REQUEST_STRUCTURE) {
        sga_json_key(w, "structure");
        sga_json_object(w);
        sga_json_key(w, "kronecker");
        sga_json_raw(w, j->kronecker.data, j->kronecker.len);
        if (j->has_structure)
            answer_write_structure(j, w);
        sga_json_end_object(w);
    }
    if (j->is_linear) {
        sga_json_key(w, "kronecker");
        sga_json_raw(w, j->kronecker.data, j->kronecker.len);
    }
    if (want & REQUEST_SYMMETRIES)
        answer_write_symmetries(j, w);
    if (j->has_initial)
        answer_write_initial(j, w);
    if (j->trajectories.len) {
        sga_json_key(w, "trajectories");
        sga_json_raw(w, j->trajectories.data, j->trajectories.len);
    }
    if (j->has_trajectory && !answer_write_trajectory(j, w))
        return false;
    write_evidence(j, w);
    write_work(j, w);
    sga_json_end_object(w);
    return answer_fits(j, out);
}
