/* The form `linear`: constant matrices, and inputs that are functions of time, variables,
 * or a feedback. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "form.h"
#include "parse.h"
#include "reader.h"

struct linear {
    struct read_matrix A, B, C, D;
    struct read_signals u;
};

/* A name that stands for nothing yet: such an input becomes a variable. */
static bool is_free_name(const struct reader *rd, const json_t *v)
{
    const char *s = json_string_value(v);
    return s && is_identifier(s) && !expr_reserved(s) && expr_symbol_find(&rd->r->store, s, strlen(s)) < 0;
}

static bool depends_on_state(const struct expr_store *st, expr_id e)
{
    return symbol_kinds(st, e) & 1u << EXPR_VARIABLE;
}

static bool read_input(struct reader *rd, struct read_signals *l, const json_t *v, int j)
{
    if (is_free_name(rd, v)) {
        int symbol = read_new_name(rd, v, EXPR_VARIABLE);
        if (symbol < 0)
            return false;
        l->input[l->free++] = symbol;
        l->u[j] = rd->r->store.symbol[symbol].node;
        return true;
    }
    expr_id e = l->u[j] = read_expression(rd, v, NULL);
    if (!e)
        return false;
    return !depends_on_state(&rd->r->store, e)
           || at_fail(rd, SGA_E_SCHEMA, "an input is a function of time, or a new name that becomes a variable");
}

/* With a feedback the inputs are D x'; what stands under `inputs` then only names them. */
static bool read_label(struct reader *rd, const json_t *v)
{
    return is_free_name(rd, v)
           || at_fail(rd, SGA_E_SCHEMA, "with D the inputs are the feedback u = D x': only new names can stand here");
}

/* labels: how many names stand there for what D gives; -1: they are the inputs. */
static bool read_list(struct reader *rd, struct read_signals *l, const json_t *v, int labels)
{
    size_t mark = at_member(rd, "inputs"), n = list_size(v);
    if (n > REQUEST_MAX_VARIABLES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu inputs; the limit is %d", n, REQUEST_MAX_VARIABLES);
    if (labels >= 0 && n != (size_t)labels)
        return at_fail(rd, SGA_E_SHAPE, "there are %zu inputs, but D has %d rows", n, labels);
    l->inputs = (int)n;
    l->u = sga_zeros(&rd->r->mem, n + 1, sizeof *l->u);
    l->input = sga_zeros(&rd->r->mem, n + 1, sizeof *l->input);
    for (size_t j = 0; j < n; j++) {
        size_t here = at_item(rd, v, j);
        const json_t *item = list_item(v, j);
        if (!(labels >= 0 ? read_label(rd, item) : read_input(rd, l, item, (int)j)))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

bool read_signals(struct reader *rd, const json_t *system, struct read_signals *out)
{
    const json_t *v = need_member(rd, system, "inputs");
    return v && read_list(rd, out, v, -1);
}

static bool read_inputs(struct reader *rd, struct linear *l, const json_t *system, bool feedback)
{
    const json_t *v = json_object_get(system, "inputs");
    return feedback ? !v || read_list(rd, &l->u, v, l->D.rows) : read_signals(rd, system, &l->u);
}

static bool read_one(struct reader *rd, const json_t *system, struct read_matrix *m, int rows, int cols)
{
    m->rows = rows;
    m->cols = cols;
    m->constant = true;
    return read_matrix(rd, system, m);
}

/* C and what it multiplies: D, or the inputs. */
static bool read_input_matrices(struct reader *rd, const json_t *system, struct linear *l, int n)
{
    bool feedback = json_object_get(system, "D") != NULL;
    if (!json_object_get(system, "C") && !json_object_get(system, "inputs") && !feedback)
        return true;
    int inputs = 0;
    if (feedback && (!read_matrix_rows(rd, system, "D", n, &inputs) || !read_one(rd, system, &l->D, inputs, n)))
        return false;
    if (!read_inputs(rd, l, system, feedback))
        return false;
    return read_one(rd, system, &l->C, l->A.rows, feedback ? inputs : l->u.inputs);
}

static bool read_all(struct reader *rd, const json_t *system, struct linear *l, int n)
{
    int rows;
    if (!read_matrix_rows(rd, system, "A", n, &rows))
        return false;
    if (rows == 0)
        return at_fail(rd, SGA_E_EMPTY_SYSTEM, "the system has no equation: A is empty");
    return read_one(rd, system, &l->A, rows, n) && read_one(rd, system, &l->B, rows, n)
        && read_input_matrices(rd, system, l, n);
}

static struct form_matrix matrix(const struct read_matrix *m)
{
    return (struct form_matrix){ .rows = m->rows, .cols = m->cols, .entry = m->entry, .entries = m->entries };
}

bool read_linear(struct reader *rd, const json_t *system)
{
    struct linear l = {
        .A = { .name = "A", .per_row = "rows", .per_col = "variables" },
        .B = { .name = "B", .per_row = "rows of A", .per_col = "variables" },
        .C = { .name = "C", .per_row = "rows of A", .per_col = "inputs" },
        .D = { .name = "D", .per_row = "inputs", .per_col = "variables" },
    };
    int variables = 0;
    int *variable = read_variables(rd, system, "variables", &variables);
    bool ok = variable && read_all(rd, system, &l, variables);
    if (ok) {
        struct form_linear f = { .variable = variable, .variables = variables, .A = matrix(&l.A), .B = matrix(&l.B),
                                 .C = matrix(&l.C), .D = matrix(&l.D), .u = l.u.u, .input = l.u.input, .inputs = l.u.free };
        form_linear(&rd->r->system, &f);
    }
    return ok;
}
