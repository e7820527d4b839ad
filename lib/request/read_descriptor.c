/* The form `descriptor`: E x' = A x + B u, y = C x + D u, in the letters of control engineers. The outputs are names for expressions. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "form.h"
#include "reader.h"

struct descriptor {
    struct read_matrix E, A, B, C, D;
    struct read_signals u;
    int *state; int states;
};

static bool read_one(struct reader *rd, const json_t *system, struct read_matrix *m, int rows, int cols)
{
    m->rows = rows;
    m->cols = cols;
    m->constant = true;
    return read_matrix(rd, system, m);
}

/* E left out is 1, and then there are as many equations as states. */
static bool read_E(struct reader *rd, const json_t *system, struct descriptor *d, int rows)
{
    if (json_object_get(system, "E"))
        return read_one(rd, system, &d->E, rows, d->states);
    if (rows != d->states)
        return at_fail(rd, SGA_E_SHAPE, "A has %d rows, but there are %d states; without E, which is 1 then, they must be as many", rows, d->states);
    d->E.rows = d->E.cols = rows;
    d->E.entry = sga_zeros(&rd->r->mem, (size_t)rows + 1, sizeof *d->E.entry);
    for (int i = 0; i < rows; i++)
        d->E.entry[d->E.entries++] = (struct form_entry){ i, i, expr_int(&rd->r->store, 1) };
    return true;
}

static bool read_equations_of(struct reader *rd, const json_t *system, struct descriptor *d)
{
    int rows;
    if (!read_matrix_rows(rd, system, "A", d->states, &rows))
        return false;
    if (rows == 0)
        return at_fail(rd, SGA_E_EMPTY_SYSTEM, "the system has no equation: A is empty");
    if (!read_E(rd, system, d, rows) || !read_one(rd, system, &d->A, rows, d->states))
        return false;
    if (!json_object_get(system, "B") && !json_object_get(system, "inputs"))
        return true;
    return read_signals(rd, system, &d->u) && read_one(rd, system, &d->B, rows, d->u.inputs);
}

static void add_rows(struct expr_store *st, const struct read_matrix *m, const expr_id *x, expr_id *sum)
{
    for (size_t k = 0; k < m->entries; k++)
        sum[m->entry[k].row] = expr_add(st, sum[m->entry[k].row], expr_mul(st, m->entry[k].value, x[m->entry[k].col]));
}

/* y = C x + D u, under the names of the outputs. */
static bool read_outputs(struct reader *rd, const json_t *system, struct descriptor *d)
{
    struct expr_store *st = &rd->r->store;
    struct request *r = rd->r;
    const json_t *v = json_object_get(system, "outputs");
    if (!v && !json_object_get(system, "C") && !json_object_get(system, "D"))
        return true;
    if (!(v = need_member(rd, system, "outputs")))
        return false;
    size_t mark = at_member(rd, "outputs");
    int n = (int)(list_size(v) < REQUEST_MAX_PORTS ? list_size(v) : REQUEST_MAX_PORTS + 1);
    if (n > REQUEST_MAX_PORTS)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu outputs; the limit is %d", list_size(v), REQUEST_MAX_PORTS);
    at_back(rd, mark);
    if (!read_one(rd, system, &d->C, n, d->states) || (json_object_get(system, "D") && !read_one(rd, system, &d->D, n, d->u.inputs)))
        return false;
    expr_id *x = sga_take(&rd->mem, ((size_t)d->states + 1) * sizeof *x);
    for (int k = 0; k < d->states; k++)
        x[k] = st->symbol[d->state[k]].node;
    r->output = sga_take(&r->mem, ((size_t)n + 1) * sizeof *r->output);
    r->output_name = sga_zeros(&r->mem, (size_t)n + 1, sizeof *r->output_name);
    for (int k = 0; k < n; k++)
        r->output[k] = expr_int(st, 0);
    add_rows(st, &d->C, x, r->output);
    add_rows(st, &d->D, d->u.u, r->output);
    at_member(rd, "outputs");
    for (int k = 0; k < n; k++) {
        size_t here = at_item(rd, v, (size_t)k);
        if (!read_alias(rd, list_item(v, (size_t)k), r->output[k]))
            return false;
        r->output_name[k] = sga_take_text(&r->mem, json_string_value(list_item(v, (size_t)k)));
        at_back(rd, here);
    }
    r->outputs = n;
    at_back(rd, mark);
    return true;
}

static struct form_matrix matrix(const struct read_matrix *m)
{
    return (struct form_matrix){ .rows = m->rows, .cols = m->cols, .entry = m->entry, .entries = m->entries };
}

bool read_descriptor(struct reader *rd, const json_t *system)
{
    struct descriptor d = {
        .E = { .name = "E", .per_row = "rows of A", .per_col = "states" },
        .A = { .name = "A", .per_row = "rows", .per_col = "states" },
        .B = { .name = "B", .per_row = "rows of A", .per_col = "inputs" },
        .C = { .name = "C", .per_row = "outputs", .per_col = "states" },
        .D = { .name = "D", .per_row = "outputs", .per_col = "inputs" },
    };
    d.state = read_variables(rd, system, "states", &d.states);
    if (!d.state || !read_equations_of(rd, system, &d) || !read_outputs(rd, system, &d))
        return false;
    struct form_linear f = { .variable = d.state, .variables = d.states, .A = matrix(&d.E), .B = matrix(&d.A), .C = matrix(&d.B), .u = d.u.u,
                             .input = d.u.input, .inputs = d.u.free };
    form_linear(&rd->r->system, &f);
    return true;
}
