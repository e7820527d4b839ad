/* The analysis of the form `operator` over Q(t)[D], and its members of the result. */
#include "answer.h"

#include <stdlib.h>
#include <string.h>

#include "from_expr.h"
#include "mem.h"
#include "text.h"

enum { TERMS = 2, FACTOR_BYTES = 1 << 20, SHOWN_BYTES = 200000 };

static const char *time_name(const struct job *j)
{
    return j->request.store.symbol[j->request.system.time].name;
}

static bool convert(struct job *j, fmpz_poly_q_struct *out, const expr_id *e, int n, const char *where, int cols)
{
    char why[160] = "";
    int k = op_from_exprs(out, &j->request.store, e, n, j->request.system.time, why);
    if (k == n)
        return true;
    char pointer[96];
    snprintf(pointer, sizeof pointer, "%s/%d/%d", where, k / cols, k % cols);
    return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, pointer, "an entry must be a rational function of time with rational "
                       "coefficients: %s", why);
}

static bool make_system(struct job *j, struct op_system *s)
{
    const struct request_operator *op = &j->request.op;
    int p = op->unknowns;
    bool ok = true;
    *s = (struct op_system){ .unknowns = p, .sources = op->sources, .order = op->order };
    s->A = sga_calloc((size_t)op->order + 1, sizeof *s->A);
    for (int k = 0; k <= op->order; k++)
        ratio_matrix_init(s->A + k, p, p);
    ratio_matrix_init(&s->B, p, op->sources);
    for (int k = 0; k <= op->order && ok; k++) {
        char where[64];
        snprintf(where, sizeof where, "/system/coefficients/%d", k);
        ok = convert(j, s->A[k].e, op->A + (size_t)k * (size_t)p * (size_t)p, p * p, where, p);
    }
    if (ok && op->sources)
        ok = convert(j, s->B.e, op->B, p * op->sources, "/system/B", op->sources);
    while (s->order > 0 && ratio_matrix_is_zero(s->A + s->order))
        ratio_matrix_clear(s->A + s->order--);
    return ok;
}

/* Not of full rank: are there equations 0 = (something in e) that ask something of e? */
static bool asks_sources(const struct op_system *s, const struct op_popov *p)
{
    struct ore_matrix B, W = { 0 };
    ore_matrix_init(&B, s->unknowns, s->sources);
    for (int k = 0; k < s->unknowns * s->sources; k++)
        if (!fmpz_poly_q_is_zero(s->B.e + k))
            ore_add_term(B.e + k, s->B.e + k, 0);
    ore_matrix_mul(&W, &p->U, &B);
    bool asks = false;
    for (int i = p->rank; i < W.rows; i++)
        for (int k = 0; k < W.cols; k++)
            asks = asks || !ore_is_zero(ore_at(&W, i, k));
    ore_matrix_clear(&B);
    ore_matrix_clear(&W);
    return asks;
}

/* A limit of the Jacobson form is no failure of the job: the answer says it. */
static bool jacobson(struct job *j, struct operator_answer *a, const struct op_limits *limits)
{
    struct op_limits own = *limits;
    own.max_bytes = FACTOR_BYTES;
    struct sga_error err = { 0 };
    a->has_jacobson = op_jacobson_form(&a->jacobson, &a->system, &own, &err);
    if (a->has_jacobson || err.code == SGA_E_LIMIT_MEMORY || err.code == SGA_E_UNDECIDED) {
        a->no_jacobson = err;
        return true;
    }
    *j->err = err;
    return false;
}

static bool transfer(struct job *j, struct operator_answer *a, const struct op_popov *weak, const struct op_limits *limits)
{
    struct ratio_matrix leading;
    int order = 0;
    bool any = op_state_leading(&a->state, &order, &leading);
    if (!any)
        return true;
    bool ok = op_laurent_series(&a->laurent, &a->system, weak, order, TERMS, limits, j->err);
    if (ok && (a->laurent.first != order || !ratio_matrix_equal(&leading, a->laurent.coefficient)))
        ok = sga_fail(j->err, SGA_E_WITNESS, "the transfer matrix begins at order %d, the state form's at %d: this is a bug",
                      a->laurent.first, order);
    ok = ok && op_singular_find(&a->singular, a->laurent.coefficient, j->err);
    ratio_matrix_clear(&leading);
    return ok;
}

bool answer_operator(struct job *j)
{
    struct operator_answer *a = sga_calloc(1, sizeof *a);
    struct op_limits limits = { .budget = &j->budget };
    struct op_popov weak = { 0 }, full = { 0 };
    struct ore_matrix P;
    double start = sga_now();
    j->op = a;
    if (!make_system(j, &a->system))
        return false;
    op_system_matrix(&a->system, &P);
    bool ok = op_popov_weak(&weak, &P, false, &limits, j->err);
    a->rank = weak.rank;
    a->solvable = ok && a->rank == P.rows;
    if (ok && a->solvable)
        ok = op_popov_weak(&full, &P, false, &limits, j->err) && op_popov_finish(&full, &limits, j->err)
          && op_state_form(&a->state, &a->system, &full, &limits, j->err) && transfer(j, a, &weak, &limits);
    else if (ok)
        a->asks_sources = asks_sources(&a->system, &weak);
    ok = ok && jacobson(j, a, &limits);
    op_popov_clear(&weak);
    op_popov_clear(&full);
    ore_matrix_clear(&P);
    j->seconds.operator_form = sga_now() - start;
    if (!ok && !j->err->stage[0])
        memcpy(j->err->stage, "operator", 9);
    return ok;
}

void answer_operator_clear(struct job *j)
{
    if (!j->op)
        return;
    op_system_clear(&j->op->system);
    op_state_clear(&j->op->state);
    op_laurent_clear(&j->op->laurent);
    op_singular_clear(&j->op->singular);
    op_jacobson_clear(&j->op->jacobson);
    free(j->op);
    j->op = NULL;
}

static void write_ratio(const struct job *j, struct sga_json *w, const fmpz_poly_q_t a)
{
    struct sga_buf text = { 0 };
    op_text_ratio(&text, a, time_name(j));
    sga_json_string(w, text.data);
    sga_buf_free(&text);
}

static void write_matrix(const struct job *j, struct sga_json *w, const struct ratio_matrix *m)
{
    sga_json_array(w);
    for (int i = 0; i < m->rows; i++) {
        sga_json_array(w);
        for (int k = 0; k < m->cols; k++)
            write_ratio(j, w, ratio_at(m, i, k));
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

/* [a0, a1, ...] */
static void write_ore(const struct job *j, struct sga_json *w, const struct ore *x)
{
    sga_json_array(w);
    for (int k = 0; k < x->len; k++)
        write_ratio(j, w, x->a + k);
    sga_json_end_array(w);
}

static void write_ore_matrix(const struct job *j, struct sga_json *w, const char *key, const struct ore_matrix *m)
{
    sga_json_key(w, key);
    sga_json_array(w);
    for (int i = 0; i < m->rows; i++) {
        sga_json_array(w);
        for (int k = 0; k < m->cols; k++)
            write_ore(j, w, ore_at(m, i, k));
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
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
            write_ore(j, w, k == f->rank - 1 ? &f->e : &one);
        sga_json_end_array(w);
        ore_clear(&one);
    }
    sga_json_key(w, "jacobson");
    sga_json_object(w);
    if (!a->has_jacobson) {
        sga_json_member_string(w, "code", sga_code_text(a->no_jacobson.code));
        sga_json_member_string(w, "detail", a->no_jacobson.detail);
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
        sga_buf_puts(&text, j->request.store.symbol[j->request.op.unknown[x->unknown[k]]].name);
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

int answer_operator_index(const struct job *j)
{
    return j->op->solvable ? j->op->state.degree + 1 : -1;
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
