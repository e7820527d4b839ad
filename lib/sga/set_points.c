/* Where points of a system's sets lie. */
#include "set_points.h"

#include <assert.h>
#include <stdlib.h>

#include "mem.h"
#include "reduction.h"
#include "system.h"
#include "table.h"

void set_points_init(struct set_points *p, const struct sys_system *sys, const struct sga_solution *sol, int constraints, int more_variables,
                     int more_constraints)
{
    assert(!constraints || constraints <= sol->constraints);
    int n = sys->variables, generations = sol ? sol->generations : 0;
    p->variable = sga_malloc((size_t)(n + more_variables + 1) * sizeof *p->variable);
    p->constraint = sga_malloc((size_t)(constraints + more_constraints + 1) * sizeof *p->constraint);
    p->end = sga_calloc((size_t)generations + 3, sizeof *p->end);
    p->stages = sol ? sga_stages(sol, constraints, p->end) : 0;
    for (int j = 0; j < n; j++)
        p->variable[j] = sys->variable[j].symbol;
    for (int i = 0; i < constraints; i++)
        p->constraint[i] = sol->constraint[i].expr;
    p->space = (struct points_space){
        .st = sys->store, .variable = p->variable, .variables = n, .parameter = sys->parameter, .parameters = sys->parameters,
        .time = sys->time, .constraint = p->constraint, .constraints = constraints, .end = p->end, .ends = p->stages };
    assert(p->stages <= generations + 1);
}

void set_points_clear(struct set_points *p)
{
    free(p->variable);
    free(p->constraint);
    free(p->end);
}

double *set_points_tables(const struct sys_system *sys, double t)
{
    double *value = sga_calloc((size_t)sys->parameters + 1, sizeof *value);
    for (int i = 0; i < sys->parameters; i++) {
        const struct expr_symbol *s = sys->store->symbol + sys->parameter[i];
        value[i] = s->table ? expr_table_value(s->table, s->order, t) : 0;
    }
    return value;
}
