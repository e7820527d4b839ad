/* The member `evidence`: what each decision rests on, and the combinations behind the constraints. */

#include <assert.h>
#include <string.h>

#include "buf.h"
#include "job_texts.h"
#include "oracle.h"
#include "points.h"
#include "poly.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "texts.h"
#include "warnings.h"
#include "witness.h"
#include "write.h"

/* e in normal form where that is found. */
static expr_id normal_form(struct job *j, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_SHOWN, NULL);
    expr_id normal = e;
    limits.budget = j->budget;
    return poly_normal(&j->request->store, e, &limits, &normal) ? normal : e;
}

/* The factor of a part of a sum that is `divisor` (EXPR_UNDEF: 1) times what is printed. A row leaves alpha - A v, so that left
 * less right counts with the other sign (`minus`); the tangency is that of the constraint as it is printed. */
static expr_id printed_factor(struct job *j, const struct sga_part *part, bool minus, expr_id divisor)
{
    struct expr_store *st = &j->request->store;
    expr_id scale = part->row < 0 && j->texts && j->texts->scale ? j->texts->scale[part->tangency] : EXPR_UNDEF, e = minus ? expr_neg(st, part->factor) : part->factor;
    if (!scale && !divisor)
        return e;
    if (scale)
        e = expr_mul(st, e, scale);
    if (divisor)
        e = expr_div(st, e, divisor);
    return normal_form(j, e);
}

/* e = *number times what is returned. */
static expr_id without_number(const struct expr_store *st, expr_id e, fmpq_t number)
{
    fmpq_one(number);
    for (;;) {
        const struct expr_node n = st->node[e];
        if (n.op == EXPR_NEG)
            fmpq_neg(number, number);
        else if (n.op == EXPR_MUL && expr_is_const(st, n.a))
            fmpq_mul(number, number, expr_const_value(st, n.a));
        else
            return e;
        e = n.op == EXPR_NEG ? n.a : n.b;
    }
}

/* x / y where that is seen to be a number; otherwise EXPR_UNDEF. */
static expr_id plain_quotient(struct expr_store *st, expr_id x, expr_id y)
{
    fmpq_t p, q;
    fmpq_init(p);
    fmpq_init(q);
    expr_id a = without_number(st, x, p), b = without_number(st, y, q), e = EXPR_UNDEF;
    bool same = a == b, turned = !same && st->node[a].op == EXPR_SUB && st->node[b].op == EXPR_SUB
         && st->node[a].a == st->node[b].b && st->node[a].b == st->node[b].a;
    if ((same || turned) && !fmpq_is_zero(q)) {
        fmpq_div(p, p, q);
        if (turned)
            fmpq_neg(p, p);
        e = expr_fmpq(st, p);
    }
    fmpq_clear(p);
    fmpq_clear(q);
    return e;
}

/* What arose is so many times the function that took its place, and that is never 0 on the set; EXPR_UNDEF: it is not known to be. */
static expr_id times_replaced(struct job *j, const struct sga_constraint *c)
{
    struct expr_store *st = &j->request->store;
    struct sga_error before = st->error;
    expr_id plain = plain_quotient(st, c->replaced, c->expr);
    if (plain)
        return plain;
    expr_id q = expr_div(st, c->replaced, c->expr), normal = EXPR_UNDEF;
    struct poly_limits limits = poly_limits_of(POLY_SHOWN, NULL);
    limits.budget = j->budget;
    bool ok = q && poly_normal(st, q, &limits, &normal)
              && (expr_is_const(st, normal) ? !expr_is_zero(st, normal)
                  : j->oracle->reals && points_oracle_zero(j->oracle, normal).basis == POINTS_NONZERO_PROVED);
    st->error = before;
    return ok ? normal : EXPR_UNDEF;
}

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
    expr_id scale = j->texts && j->texts->scale ? j->texts->scale[i] : EXPR_UNDEF, times = c->replaced ? times_replaced(j, c) : EXPR_UNDEF;
    struct sga_buf text = { 0 };
    bool stands_for = c->replaced && !times, has_text = stands_for && expr_print(st, c->replaced, 4000, &text);
    expr_id divisor = stands_for ? EXPR_UNDEF : !times ? scale : !scale ? times : expr_mul(st, times, scale);
    sga_json_object(w);
    sga_json_member_int(w, "generation", c->generation);
    sga_json_member_string(w, "from", c->origin == SGA_FROM_RESTRICTION ? "restriction" : "combination");
    sga_json_key(w, "combination");
    write_parts(j, w, c->part, stands_for && !has_text ? 0 : c->parts, divisor);
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
        expr_json(&j->request->store, normal_form(j, sol->pivot[q].value), 400, w);
        sga_json_key(w, "basis");
        struct points_decision d = points_oracle_zero(j->oracle, sol->pivot[q].value);
        sga_json_string(w, points_basis_text(d.basis));
        sga_json_end_object(w);
        written++;
    }
    sga_json_end_array(w);
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
    sga_json_array(w);
    for (int i = 0; i < sol->constraints; i++)
        write_constraint(j, w, i);
    sga_json_end_array(w);
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
