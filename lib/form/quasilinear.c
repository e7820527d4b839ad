/* The form that needs no translation: entries go to rows, transposed or not. */
#include "form.h"

#include <assert.h>
#include <stdio.h>

void form_quasilinear(struct sys_system *s, const struct form_quasilinear *in)
{
    int rows = in->transpose ? in->cols : in->rows;
    int cols = in->transpose ? in->rows : in->cols;
    assert(cols == in->variables);
    for (int j = 0; j < cols; j++)
        sys_add_variable(s, in->variable[j], "variable");
    for (int i = 0; i < rows; i++) {
        char source[32];
        snprintf(source, sizeof source, "row %d", i);
        sys_add_row(s, in->alpha[i], source);
    }
    for (size_t k = 0; k < in->entries; k++) {
        const struct form_entry *e = in->entry + k;
        sys_add_entry(s, in->transpose ? e->col : e->row, in->transpose ? e->row : e->col, e->value);
    }
    for (int i = 0; i < in->restrictions; i++)
        sys_add_restriction(s, in->restriction[i]);
    s->square = rows == cols && !in->restrictions;
}
