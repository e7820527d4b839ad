/* A control system on the zero set of its constraints: the inputs are variables without
 * an equation of their own. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "form.h"
#include "mem.h"

void form_control(struct sys_system *s, const struct form_control *in)
{
    struct expr_store *st = s->store;
    int n = in->variables;
    assert(in->G.rows == in->inputs && in->G.cols == n);
    SGA_FREED expr_id *alpha = sga_malloc((size_t)n * sizeof *alpha + 1);
    memcpy(alpha, in->F, (size_t)n * sizeof *alpha);
    for (size_t k = 0; k < in->G.entries; k++) {
        const struct form_entry *e = in->G.entry + k;
        alpha[e->col] = expr_add(st, alpha[e->col], expr_mul(st, e->value, st->symbol[in->input[e->row]].node));
    }
    for (int j = 0; j < n; j++)
        sys_add_variable(s, in->variable[j], "variable");
    for (int j = 0; j < in->inputs; j++)
        sys_add_variable(s, in->input[j], "input");
    struct sga_buf source = { 0 };
    for (int i = 0; i < n; i++) {
        sga_buf_clear(&source);
        sga_buf_printf(&source, "equation of %s", st->symbol[in->variable[i]].name);
        sys_add_entry(s, sys_add_row(s, alpha[i], source.data), i, expr_int(st, 1));
    }
    for (int i = 0; i < in->constraints; i++) {
        sga_buf_clear(&source);
        sga_buf_printf(&source, "constraints[%d]", i);
        sys_add_row(s, in->constraint[i], source.data);
    }
    sga_buf_free(&source);
    s->square = in->constraints == in->inputs;
}
