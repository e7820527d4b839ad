/* The form `operator`: sum A_i y^(i) = B e, matrices of rational functions of time.
 *
 * The matrices are kept as they stand for the analysis over Q(t)[d/dt]; beside that the system is
 * handed to the form `equations`, so that the reduction runs on it like on any other. A
 * source that is only named stands for any function: the reduction then runs with it
 * left out, which changes no rank. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "equations.h"
#include "error.h"
#include "form.h"
#include "reader.h"

static bool only_time(const struct expr_store *st, expr_id e)
{
    return !(symbol_kinds(st, e) & ~(1u << EXPR_TIME | 1u << EXPR_PARAMETER | 1u << EXPR_SIGNAL));
}

/* Perhaps in Q(t): a table is not. */
static bool rational(const struct expr_store *st, expr_id e)
{
    return only_time(st, e) && !(symbol_kinds(st, e) & 1u << EXPR_SIGNAL);
}

/* The matrix at a place of the JSON, dense, into zeroed handles of rows x cols. */
static bool read_dense(struct reader *rd, const json_t *v, const char *name, expr_id *out, int rows, int cols, const char *per_col)
{
    struct read_matrix m = { .name = name, .rows = rows, .cols = cols, .per_row = "unknowns", .per_col = per_col };
    bool ok = read_matrix_value(rd, v, &m);
    for (int k = 0; k < rows * cols; k++)
        out[k] = expr_int(&rd->r->store, 0);
    for (size_t k = 0; k < m.entries && ok; k++) {
        expr_id *to = out + m.entry[k].row * cols + m.entry[k].col;
        ok = rational(&rd->r->store, m.entry[k].value);
        if (!ok && json_is_array(v)) {
            at_index(rd, (size_t)m.entry[k].row);
            at_index(rd, (size_t)m.entry[k].col);
        }
        ok = ok || at_fail(rd, SGA_E_SCHEMA, "the entries of %s are rational functions of time alone", name);
        *to = expr_add(&rd->r->store, *to, m.entry[k].value);
    }
    return ok;
}

static bool read_coefficients(struct reader *rd, const json_t *system, struct request_operator *op)
{
    const json_t *v = need_member(rd, system, "coefficients");
    if (!v)
        return false;
    size_t mark = at_member(rd, "coefficients"), n = json_is_array(v) ? json_array_size(v) : 0;
    if (n == 0)
        return at_fail(rd, SGA_E_EMPTY_SYSTEM, "coefficients is a list of matrices [A0, A1, ...]");
    if (n > FORM_MAX_ORDER + 1)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "the order is %zu; the limit is %d", n - 1, FORM_MAX_ORDER);
    op->order = (int)n - 1;
    assert(op->order >= 0 && op->unknowns > 0);
    size_t square = (size_t)op->unknowns * (size_t)op->unknowns;
    op->A = sga_zeros(&rd->r->mem, n * square + 1, sizeof *op->A);
    for (size_t k = 0; k < n; k++) {
        size_t here = at_index(rd, k);
        if (!read_dense(rd, json_array_get(v, k), "coefficients", op->A + k * square, op->unknowns, op->unknowns, "unknowns"))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

/* A new name stands for any function of time; anything else is one. */
static bool read_source(struct reader *rd, struct request_operator *op, const json_t *v, int k)
{
    const char *s = json_string_value(v);
    if (s && is_identifier(s) && !expr_reserved(s) && expr_symbol_find(&rd->r->store, s, strlen(s)) < 0) {
        op->source[k] = EXPR_UNDEF;
        op->source_name[k] = sga_take_text(&rd->r->mem, s);
        op->open_sources = true;
        return true;
    }
    op->source[k] = read_listed(rd, v, &op->source_name[k]);
    return op->source[k]
           && (only_time(&rd->r->store, op->source[k])
               || at_fail(rd, SGA_E_SCHEMA, "a source is a new name or a function of time"));
}

static void default_sources(struct sga_arena *mem, struct request_operator *op)
{
    for (int k = 0; k < op->sources; k++) {
        char name[32];
        snprintf(name, sizeof name, "e%d", k + 1);
        op->source_name[k] = sga_take_text(mem, name);
    }
    op->open_sources = op->sources > 0;
}

/* B and the sources: without B there is one source for each equation, without sources they
 * are called e1, e2, ... */
static bool read_sources(struct reader *rd, const json_t *system, struct request_operator *op)
{
    const json_t *sources = json_object_get(system, "sources"), *B = json_object_get(system, "B");
    int p = op->unknowns;
    op->sources = sources ? (int)list_size(sources) : p;
    if (!sources && B && json_is_array(B) && json_array_size(B))
        op->sources = (int)list_size(json_array_get(B, 0));
    if (!sources && B && json_is_object(B))
        op->sources = (int)json_integer_value(json_object_get(B, "cols"));
    if (op->sources > REQUEST_MAX_VARIABLES || op->sources < 0)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %d sources; the limit is %d", op->sources, REQUEST_MAX_VARIABLES);
    op->source = sga_zeros(&rd->r->mem, (size_t)op->sources + 1, sizeof *op->source);
    op->source_name = sga_zeros(&rd->r->mem, (size_t)op->sources + 1, sizeof *op->source_name);
    op->B = sga_zeros(&rd->r->mem, (size_t)p * (size_t)op->sources + 1, sizeof *op->B);
    size_t mark = rd->at.len;
    if (B) {
        at_member(rd, "B");
        if (!read_dense(rd, B, "B", op->B, p, op->sources, "sources"))
            return false;
        at_back(rd, mark);
    } else if (op->sources != p) {
        at_member(rd, "sources");
        return at_fail(rd, SGA_E_SHAPE, "there are %d sources for %d equations: say by a matrix B how they enter", op->sources, p);
    } else {
        for (int k = 0; k < p * p; k++)
            op->B[k] = expr_int(&rd->r->store, k % (p + 1) == 0);
    }
    if (!sources) {
        default_sources(&rd->r->mem, op);
        return true;
    }
    at_member(rd, "sources");
    for (int k = 0; k < op->sources; k++) {
        size_t here = at_item(rd, sources, (size_t)k);
        if (!read_source(rd, op, list_item(sources, (size_t)k), k))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

/* sum A_i y^(i) - B e, row by row, as equations. */
static bool as_equations(struct reader *rd, const struct request_operator *op)
{
    struct expr_store *st = &rd->r->store;
    SGA_ENDS(form_equations_clear) struct form_equations f;
    int p = op->unknowns;
    form_equations_init(&f, st);
    for (int j = 0; j < p; j++)
        form_equations_unknown(&f, op->unknown[j]);
    for (int i = 0; i < p; i++) {
        expr_id sum = expr_int(st, 0);
        for (int k = 0; k <= op->order; k++)
            for (int j = 0; j < p; j++) {
                expr_id a = op->A[((size_t)k * (size_t)p + (size_t)i) * (size_t)p + (size_t)j];
                if (expr_is_zero(st, a))
                    continue;
                expr_id y = k ? form_equations_derivative(&f, op->unknown[j], k) : st->symbol[op->unknown[j]].node;
                sum = expr_add(st, sum, expr_mul(st, a, y));
            }
        for (int j = 0; j < op->sources; j++)
            if (op->source[j])
                sum = expr_sub(st, sum, expr_mul(st, op->B[(size_t)i * (size_t)op->sources + (size_t)j], op->source[j]));
        form_equations_add(&f, sum);
    }
    return form_equations_reduce(&f, &rd->r->system, REQUEST_MAX_VARIABLES, rd->err);
}

bool read_operator(struct reader *rd, const json_t *system)
{
    struct request_operator *op = &rd->r->op;
    op->unknown = read_variables(rd, system, "unknowns", &op->unknowns);
    bool ok = op->unknown != NULL;
    if (ok && op->unknowns > REQUEST_MAX_UNKNOWNS) {
        at_member(rd, "unknowns");
        ok = at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %d unknowns; the limit of this form is %d", op->unknowns,
                     REQUEST_MAX_UNKNOWNS);
    }
    const char *open = rd->symbolic[0] ? rd->symbolic : rd->r->swept_count ? rd->r->store.symbol[rd->r->swept[0].symbol].name : NULL;
    if (ok && open) {
        at_member(rd, "parameters");
        ok = at_fail(rd, SGA_E_NOT_SUPPORTED, "the field of this form is Q(t): the parameter %s needs a value%s", open,
                     rd->symbolic[0] ? "" : ", so that it cannot be swept; send a request for each value");
    }
    ok = ok && read_coefficients(rd, system, op) && read_sources(rd, system, op) && as_equations(rd, op);
    op->has = ok;
    return ok;
}
