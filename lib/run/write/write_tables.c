/* Tables in the result: what they are, and which derivatives the answer rests on. */
#include "run_job.h"

#include <stdlib.h>

#include "arena.h"
#include "buf.h"
#include "reduction.h"
#include "request.h"
#include "table.h"
#include "write.h"

/* The highest derivative of a table in constraints, field and gauge fields; -1: none of them depends on it. */
static int order_of(const struct job *j, const struct expr_table *table)
{
    const struct sga_solution *s = j->solution;
    const struct expr_store *st = &j->request->store;
    int n = j->request->system.variables, order = -1, roots = 0;
    SGA_ARENA(mem);
    expr_id *root = sga_take(&mem, ((size_t)s->constraints + (size_t)(s->free_columns + 1) * (size_t)n + 1) * sizeof *root);
    for (int i = 0; i < s->constraints; i++)
        root[roots++] = s->constraint[i].expr;
    for (int i = 0; i < n && s->field; i++)
        root[roots++] = s->field[i];
    for (int i = 0; i < n * s->free_columns && s->gauge; i++)
        root[roots++] = s->gauge[i];
    if (s->contradiction)
        root[roots++] = s->contradiction;
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, root, roots);
    for (int k = 0; k < cone.count; k++) {
        const struct expr_node *node = st->node + cone.list[k];
        const struct expr_symbol *symbol = node->op == EXPR_SYM ? st->symbol + node->a : NULL;
        if (symbol && symbol->table == table && symbol->order > order)
            order = symbol->order;
    }
    expr_cone_clear(&cone);
    return order;
}

void answer_write_tables(const struct job *j, struct sga_json *w)
{
    if (!j->request->tables)
        return;
    sga_json_key(w, "tables");
    sga_json_array(w);
    for (int k = 0; k < j->request->tables; k++) {
        const struct expr_table *u = j->request->table[k].values;
        int order = order_of(j, u);
        sga_json_object(w);
        sga_json_member_string(w, "name", j->request->table[k].name);
        sga_json_member_string(w, "interpolation", u->kind == EXPR_LINEAR ? "linear" : "cubic");
        sga_json_member_int(w, "knots", u->knots);
        sga_json_member_double(w, "from", u->time[0]);
        sga_json_member_double(w, "to", u->time[u->knots - 1]);
        sga_json_key(w, "derivatives");
        if (order < 0)
            sga_json_null(w);
        else
            sga_json_int(w, order);
        sga_json_member_string(w, "analysis", "holds for every function of time in its place");
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}
