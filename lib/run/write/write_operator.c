/* The members of the result that the form `operator` adds. */
#include "run_job.h"

#include "buf.h"
#include "error.h"
#include "operator.h"
#include "operator_answer.h"
#include "operator_json.h"
#include "ore.h"
#include "request.h"
#include "text.h"
#include "write.h"

enum { SHOWN_BYTES = 200000 };

static const char *time_name(const struct job *j)
{
    return j->request->store.symbol[j->request->system.time].name;
}

static void write_matrix(const struct job *j, struct sga_json *w, const struct ratio_matrix *m)
{
    op_json_ratios(w, m, time_name(j));
}

static void write_ore_matrix(const struct job *j, struct sga_json *w, const char *key, const struct ore_matrix *m)
{
    sga_json_key(w, key);
    op_json_ores(w, m, time_name(j));
}

static void write_jacobson(const struct job *j, struct sga_json *w)
{
    const struct operator_answer *a = j->op;
    const struct op_jacobson *f = &a->jacobson;
    sga_json_key(w, "invariant_factors");
    if (!a->has_jacobson) {
        sga_json_null(w);
    } else {
        struct ore one;
        ore_init(&one);
        ore_one(&one);
        sga_json_array(w);
        for (int k = 0; k < f->rank; k++)
            op_json_ore(w, k == f->rank - 1 ? &f->e : &one, time_name(j));
        sga_json_end_array(w);
        ore_clear(&one);
    }
    sga_json_key(w, "jacobson");
    sga_json_object(w);
    if (!a->has_jacobson) {
        sga_json_member_string(w, "code", sga_code_text(a->no_jacobson.code));
        sga_json_member_string(w, "detail", a->no_jacobson.detail);
    } else if (!f->transformations) {
        sga_json_member_string(w, "code", sga_code_text(SGA_E_LIMIT_MEMORY));
        struct sga_buf text = { 0 };
        sga_buf_printf(&text, "the last invariant factor has %zu kB; its transformations are worked out up to %d kB",
                       ore_size(&f->e) / 1000, OP_MOST_FACTOR_BYTES / 1000);
        sga_json_member_string(w, "detail", text.data);
        sga_buf_free(&text);
    } else if (ore_matrix_size(&f->U) + ore_matrix_size(&f->V) + ore_matrix_size(&f->U_inverse) > SHOWN_BYTES) {
        sga_json_member_string(w, "detail", "the transformations were found and multiplied out, but are too large to be shown");
    } else {
        write_ore_matrix(j, w, "U", &f->U);
        write_ore_matrix(j, w, "V", &f->V);
        write_ore_matrix(j, w, "U_inverse", &f->U_inverse);
        write_ore_matrix(j, w, "V_inverse", &f->V_inverse);
    }
    sga_json_end_object(w);
}

static void write_state(const struct job *j, struct sga_json *w)
{
    const struct op_state *x = &j->op->state;
    sga_json_key(w, "state");
    sga_json_object(w);
    sga_json_member_int(w, "dimension", x->n);
    sga_json_key(w, "F");
    write_matrix(j, w, &x->F);
    sga_json_key(w, "G");
    write_matrix(j, w, &x->G);
    sga_json_key(w, "H");
    write_matrix(j, w, &x->H);
    sga_json_key(w, "J");
    sga_json_array(w);
    for (int v = 0; v <= x->degree; v++)
        write_matrix(j, w, x->J + v);
    sga_json_end_array(w);
    sga_json_key(w, "components");           /* of x, without their terms in e */
    sga_json_array(w);
    for (int k = 0; k < x->n; k++) {
        struct sga_buf text = { 0 };
        sga_buf_puts(&text, j->request->store.symbol[j->request->op.unknown[x->unknown[k]]].name);
        for (int d = 0; d < x->derivative[k]; d++)
            sga_buf_puts(&text, "'");
        sga_json_string(w, text.data);
        sga_buf_free(&text);
    }
    sga_json_end_array(w);
    sga_json_end_object(w);
}

static void write_laurent(const struct job *j, struct sga_json *w)
{
    const struct op_laurent *g = &j->op->laurent;
    sga_json_key(w, "transfer_leading_order");
    if (!g->terms) {
        sga_json_null(w);
        return;
    }
    sga_json_int(w, g->first);
    sga_json_key(w, "transfer");
    sga_json_object(w);
    sga_json_member_int(w, "first", g->first);
    sga_json_key(w, "coefficients");
    sga_json_array(w);
    for (int k = 0; k < g->terms; k++)
        write_matrix(j, w, g->coefficient + k);
    sga_json_end_array(w);
    sga_json_end_object(w);
}

static void write_rational(struct sga_json *w, const fmpq_t q)
{
    char *s = fmpq_get_str(NULL, 10, q);
    sga_json_string(w, s);
    flint_free(s);
}

static void write_singular(const struct job *j, struct sga_json *w)
{
    const struct op_singular_times *s = &j->op->singular;
    sga_json_key(w, "singular_times");
    sga_json_array(w);
    for (int k = 0; k < s->count; k++) {
        const struct op_singular *r = s->at + k;
        struct sga_buf text = { 0 };
        sga_json_object(w);
        sga_json_member_double(w, "t", r->t);
        sga_buf_printf(&text, r->lost == OP_POLE ? "the leading transfer coefficient (order %d) has a pole of order %d"
                       : "the leading transfer coefficient (order %d) vanishes to order %d", j->op->laurent.first, r->order);
        sga_json_member_string(w, "lost", text.data);
        sga_buf_clear(&text);
        op_text_polynomial(&text, r->polynomial, time_name(j));
        sga_json_member_string(w, "root_of", text.data);
        sga_buf_free(&text);
        sga_json_key(w, "interval");
        sga_json_array(w);
        write_rational(w, r->low);
        write_rational(w, r->high);
        sga_json_end_array(w);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

void answer_write_operator(const struct job *j, struct sga_json *w)
{
    const struct operator_answer *a = j->op;
    sga_json_member_bool(w, "solvable", a->solvable);
    sga_json_member_int(w, "rank", a->rank);
    write_jacobson(j, w);
    if (!a->solvable)
        return;
    write_laurent(j, w);
    write_state(j, w);
    write_singular(j, w);
}
