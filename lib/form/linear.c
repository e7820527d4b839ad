/* Constant matrices: B x and C u are written out, the feedback goes into A. */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

#include "arena.h"
#include "form.h"
#include "mem.h"

static void add_product(struct expr_store *st, expr_id *sum, expr_id a, expr_id b)
{
    *sum = expr_add(st, *sum, expr_mul(st, a, b));
}

/* A - C D: the entries of D by rows, by counting, so that each entry of C meets its row only. */
static void subtract_feedback(struct sys_system *s, const struct form_matrix *C, const struct form_matrix *D)
{
    SGA_ARENA(mem);
    size_t *first = sga_zeros(&mem, (size_t)D->rows + 2, sizeof *first);
    size_t *sorted = sga_take(&mem, (D->entries + 1) * sizeof *sorted);
    for (size_t k = 0; k < D->entries; k++)
        first[D->entry[k].row + 2]++;
    for (int i = 2; i <= D->rows; i++)
        first[i] += first[i - 1];
    for (size_t k = 0; k < D->entries; k++)
        sorted[first[D->entry[k].row + 1]++] = k;
    for (size_t k = 0; k < C->entries; k++) {
        const struct form_entry *c = C->entry + k;
        for (size_t i = first[c->col]; i < first[c->col + 1]; i++) {
            const struct form_entry *d = D->entry + sorted[i];
            sys_add_entry(s, c->row, d->col, expr_neg(s->store, expr_mul(s->store, c->value, d->value)));
        }
    }
}

void form_linear(struct sys_system *s, const struct form_linear *in)
{
    struct expr_store *st = s->store;
    SGA_FREED expr_id *alpha = sga_malloc(((size_t)in->A.rows + 1) * sizeof *alpha);
    assert(in->A.cols == in->variables && in->B.rows == in->A.rows && in->B.cols == in->variables);
    for (int j = 0; j < in->variables; j++)
        sys_add_variable(s, in->variable[j], "variable");
    for (int j = 0; j < in->inputs; j++)
        sys_add_variable(s, in->input[j], "input");
    for (int i = 0; i < in->A.rows; i++)
        alpha[i] = expr_int(st, 0);
    for (size_t k = 0; k < in->B.entries; k++) {
        const struct form_entry *e = in->B.entry + k;
        add_product(st, alpha + e->row, e->value, st->symbol[in->variable[e->col]].node);
    }
    for (size_t k = 0; k < in->C.entries && !in->D.rows; k++) {
        const struct form_entry *e = in->C.entry + k;
        add_product(st, alpha + e->row, e->value, in->u[e->col]);
    }
    for (int i = 0; i < in->A.rows; i++) {
        char source[32];
        snprintf(source, sizeof source, "row %d", i);
        sys_add_row(s, alpha[i], source);
    }
    for (size_t k = 0; k < in->A.entries; k++)
        sys_add_entry(s, in->A.entry[k].row, in->A.entry[k].col, in->A.entry[k].value);
    if (in->D.rows)
        subtract_feedback(s, &in->C, &in->D);
    s->square = in->A.rows == in->variables + in->inputs;
}
