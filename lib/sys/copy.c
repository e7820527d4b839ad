/* Copies of systems, whole or in part, with symbols replaced. */
#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "mem.h"
#include "system.h"

static expr_id replaced(struct expr_store *st, expr_id e, const expr_id *map)
{
    if (map)
        expr_substitute(st, &e, 1, map);
    return e;
}

void sys_copy_part(struct sys_system *to, const struct sys_system *from, const struct sys_part *part, const expr_id *map)
{
    struct expr_store *st = from->store;
    int variables = part ? part->variables : from->variables, rows = part ? part->rows : from->rows;
    SGA_FREED int *place = sga_malloc(((size_t)from->variables + 1) * sizeof *place);
    sys_init(to, st);
    to->time = from->time;
    to->square = from->square;
    for (int j = 0; j < variables; j++) {
        int v = part ? part->variable[j] : j;
        place[v] = j;
        sys_add_variable(to, from->variable[v].symbol, from->variable[v].role);
    }
    for (int i = 0; i < from->parameters; i++)
        if (!map || !map[from->parameter[i]])
            sys_add_parameter(to, from->parameter[i]);
    for (int i = 0; i < from->signals; i++)
        sys_add_signal(to, from->signal[i]);
    for (int i = 0; i < rows; i++) {
        const struct sys_row *r = from->row + (part ? part->row[i] : i);
        int row = sys_add_row(to, replaced(st, r->alpha, map), r->source);
        for (int k = 0; k < r->entries; k++)
            sys_add_entry(to, row, place[r->entry[k].col], replaced(st, r->entry[k].value, map));
    }
    for (int i = 0; i < from->restrictions; i++)
        sys_add_restriction(to, replaced(st, from->restriction[i], map));
    assert(to->rows == rows && to->variables == variables);
}

void sys_copy(struct sys_system *to, const struct sys_system *from)
{
    sys_copy_part(to, from, NULL, NULL);
}
