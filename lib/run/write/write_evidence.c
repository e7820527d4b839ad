/* The member `evidence`: what each decision rests on, and the combinations behind the constraints. */

#include <assert.h>
#include <string.h>

#include "buf.h"
#include "job_texts.h"
#include "oracle.h"
#include "points.h"
#include "print.h"
#include "printed_parts.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "texts.h"
#include "warnings.h"
#include "witness.h"
#include "write.h"

static void write_parts(struct job *j, struct sga_json *w, const struct sga_part *part, int parts, expr_id divisor)
{
    sga_json_array(w);
    for (int k = 0; k < parts; k++) {
        sga_json_object(w);
        if (part[k].row >= 0) {
            sga_json_member_string(w, "equation", j->request->system.row[part[k].row].source);
        } else {
            sga_json_member_int(w, "tangency_of", part[k].tangency);
        }
        sga_json_key(w, "factor");
        expr_json(&j->request->store, printed_factor(j, part + k, part[0].row >= 0, divisor), 400, w);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

/* The combination that makes the printed constraint, or what it stands for. */
static void write_constraint(struct job *j, struct sga_json *w, int i)
{
    assert(i >= 0 && i < j->solution->constraints);
    const struct sga_constraint *c = j->solution->constraint + i;
    struct expr_store *st = &j->request->store;
    struct printed_sum sum = printed_sum(j, i);
    struct sga_buf text = { 0 };
    bool stands_for = sum.stands_for, has_text = stands_for && expr_print(st, c->replaced, 4000, &text);
    sga_json_object(w);
    sga_json_member_int(w, "generation", c->generation);
    sga_json_member_string(w, "from", c->origin == SGA_FROM_RESTRICTION ? "restriction" : "combination");
    sga_json_key(w, "combination");
    write_parts(j, w, c->part, stands_for && !has_text ? 0 : c->parts, sum.divisor);
    if (j->texts && j->texts->reduced && j->texts->reduced[i])      /* the combination is the constraint there only */
        sga_json_member_bool(w, "on_constraints", true);
    if (stands_for) {
        if (has_text)
            sga_json_member_string(w, "in_place_of", text.data);
        if (c->near_point)        /* its other zeros, if any, were not looked for */
            sga_json_member_bool(w, "near_point_only", true);
    }
    sga_buf_free(&text);
    sga_json_end_object(w);
}

/* What was divided by: every pivot that is not a number, assumed not to vanish. */
static void write_pivots(struct job *j, struct sga_json *w)
{
    const struct sga_solution *sol = j->solution;
    int written = 0;
    sga_json_key(w, "pivots");
    size_t start = w->out->len;
    sga_json_array(w);
    for (int q = 0; q < sol->pivots; q++) {
        if (expr_is_const(&j->request->store, sol->pivot[q].value))
            continue;
        if (written == SGA_MOST_PIVOTS_LISTED) {
            sga_limit_met(j->budget, SGA_LIMIT_PIVOTS_LISTED);
            break;
        }
        sga_json_object(w);
        if (sol->pivot[q].col >= 0) {       /* else a factor dropped from a constraint */
            sga_json_member_string(w, "velocity_of", answer_variable_name(j, sol->pivot[q].col));
        }
        sga_json_member_int(w, "generation", sol->pivot[q].generation);
        sga_json_key(w, "assumed_not_zero");
        expr_json(&j->request->store, printed_normal(j, sol->pivot[q].value), 400, w);
        sga_json_key(w, "basis");
        struct points_decision d = points_oracle_zero(j->oracle, sol->pivot[q].value);
        sga_json_string(w, points_basis_text(d.basis));
        sga_json_end_object(w);
        written++;
    }
    sga_json_end_array(w);
    answer_fold(j, w, start);
}

/* What was found to vanish on the present set, and what that rests on. */
static void write_zeros(struct job *j, struct sga_json *w)
{
    sga_json_key(w, "zeros");
    sga_json_array(w);
    for (int i = 0; i < j->oracle->zeros; i++) {
        const struct points_zero *z = j->oracle->zero + i;
        sga_json_object(w);
        sga_json_key(w, "expression");
        expr_json(&j->request->store, z->expr, 400, w);
        sga_json_member_string(w, "basis", points_basis_text(z->decision.basis));
        sga_json_member_int(w, "digits", z->decision.digits);
        sga_json_member_int(w, "real_points", z->decision.points);
        sga_json_member_int(w, "modular_points", z->decision.modular);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

/* What would have to vanish, and what it was made of. */
static void write_contradiction(struct job *j, struct sga_json *w, const char *member)
{
    const struct sga_solution *sol = j->solution;
    sga_json_key(w, member);
    sga_json_object(w);
    sga_json_key(w, "expression");
    expr_json(&j->request->store, sol->contradiction, 4000, w);
    sga_json_member_string(w, "why", sol->contradiction_why);
    sga_json_key(w, "combination");
    write_parts(j, w, sol->contradiction_part, sol->contradiction_parts, EXPR_UNDEF);
    sga_json_end_object(w);
}

/* What became of the search for zeros of each dense block's determinant. */
static void write_determinants(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "determinants");
    sga_json_array(w);
    for (int q = 0; q < j->solution->dense_blocks; q++) {
        sga_json_object(w);
        sga_json_member_int(w, "size", j->solution->determinant[q].size);
        sga_json_member_string(w, "zeros", j->strata.determinant[q]);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

void answer_write_evidence(struct job *j, struct sga_json *w)
{
    const struct sga_solution *sol = j->solution;
    sga_json_key(w, "evidence");
    sga_json_object(w);
    answer_write_slice(j, w);
    sga_json_key(w, "decisions");
    sga_json_object(w);
    for (int k = 0; k < POINTS_BASES; k++) {
        sga_json_key(w, points_basis_text((enum points_basis)k));
        sga_json_int(w, j->oracle->count[k]);
    }
    sga_json_member_int(w, "real_points", j->oracle->reals);
    sga_json_key(w, "real_points_certified");
    int certified = 0;
    for (int k = 0; k < j->oracle->reals; k++)
        certified += j->oracle->real[k].certified;
    sga_json_int(w, certified);
    sga_json_member_int(w, "modular_points", j->oracle->modulars);
    if (j->oracle->count[POINTS_ZERO_NUMERIC]) {
        sga_json_member_int(w, "least_digits", j->oracle->least_digits);
    }
    sga_json_end_object(w);
    sga_json_key(w, "constraints");
    size_t start = w->out->len;
    sga_json_array(w);
    for (int i = 0; i < sol->constraints; i++)
        write_constraint(j, w, i);
    sga_json_end_array(w);
    answer_fold(j, w, start);
    if (texts_written(j) && sol->verdict != SGA_INCONSISTENT)
        write_pivots(j, w);
    if (texts_written(j))
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
            sga_json_object(w);
            sga_json_key(w, "function");
            expr_json(&j->request->store, sol->side[i].function, 1000, w);
            sga_json_member_string(w, "sign", sol->side[i].sign > 0 ? "positive" : "negative");
            sga_json_member_string(w, "beyond", sol->side[i].unseen ? "not_found" : "other");
            sga_json_end_object(w);
        }
        sga_json_end_array(w);
    }
    if (sol->sides_not_searched)
        sga_json_member_bool(w, "sides_not_searched", true);
    if (sol->not_factored) {      /* a branch may have gone unseen */
        sga_json_member_bool(w, "factors_not_searched", true);
    }
    if (j->strata.skipped)        /* what vanishes there is not among the strata */
        sga_json_member_bool(w, "strata_not_searched", true);
    if (sol->dense_blocks) {      /* their zeros are not among the strata */
        sga_json_member_int(w, "determinants_assumed_not_zero", sol->dense_blocks);
    }
    if (sol->dense_blocks && j->strata.determinant)
        write_determinants(j, w);
    sga_json_member_int(w, "redundant_equations", sol->redundant_rows);
    answer_write_restrictions(j, w);
    if (j->redundants) {
        sga_json_key(w, "redundant_holonomic");
        sga_json_array(w);
        for (int k = 0; k < j->redundants; k++)
            sga_json_int(w, j->redundant[k]);
        sga_json_end_array(w);
    }
    if (j->witness) {
        sga_json_key(w, "witness");
        sga_json_object(w);
        sga_json_member_int(w, "points", j->witness->points);
        sga_json_member_int(w, "far", j->witness->far);
        sga_json_member_bool(w, "certified", j->witness->certified);
        sga_json_member_int(w, "digits", j->witness->digits);
        sga_json_member_string(w, "checked", sol->verdict == SGA_INCONSISTENT ? "the contradiction at points of the earlier constraints"
                           : texts_written(j) ? "the printed expressions, read back" : "the expressions");
        sga_json_end_object(w);
    }
    sga_json_end_object(w);
}
