/* A pencil as it is given: two lists of entries. */
#include "pencil.h"

#include <assert.h>
#include <stdlib.h>

#include "mem.h"

void pencil_init(struct pencil *p, int rows, int cols)
{
    *p = (struct pencil){ .rows = rows, .cols = cols };
}

static void matrix_clear(struct pencil_matrix *m)
{
    for (int i = 0; i < m->entries; i++)
        fmpq_clear(&m->entry[i].value);
    free(m->entry);
    *m = (struct pencil_matrix){ 0 };
}

void pencil_clear(struct pencil *p)
{
    matrix_clear(&p->A);
    matrix_clear(&p->B);
}

void pencil_add(struct pencil_matrix *m, int row, int col, const fmpq_t value)
{
    assert(row >= 0 && col >= 0);
    SGA_RESERVE(m->entry, m->cap, (size_t)m->entries + 1);
    struct pencil_entry *e = m->entry + m->entries++;
    e->row = row;
    e->col = col;
    fmpq_init(&e->value);
    fmpq_set(&e->value, value);
}
