/* The stages of the structure, on one finished reduction. */
#include "parts.h"

#include <stdlib.h>

#include "mem.h"

static void work_init(struct structure_work *w, const struct sys_system *sys)
{
    expr_cone_init(&w->cone);
    points_shadow_init(&w->space, 20250711);
    w->symbols = sys->store->symbols;
    w->column = sga_malloc(((size_t)w->symbols + 1) * sizeof *w->column);
    w->active = sga_calloc((size_t)w->symbols + 1, 1);
    for (int i = 0; i < w->symbols; i++)
        w->column[i] = -1;
    for (int j = 0; j < sys->variables; j++) {
        w->column[sys->variable[j].symbol] = j;
        w->active[sys->variable[j].symbol] = 1;
    }
}

/* The reduction is over, and so are the arrays that its shadow knew. */
static void space_of(const struct sys_system *sys, const struct sga_solution *sol, struct points_shadow *shadow,
                     struct structure *out)
{
    out->variable = sga_malloc(((size_t)sys->variables + 1) * sizeof *out->variable);
    out->constraint = sga_malloc(((size_t)sol->constraints + 1) * sizeof *out->constraint);
    for (int j = 0; j < sys->variables; j++)
        out->variable[j] = sys->variable[j].symbol;
    for (int i = 0; i < sol->constraints; i++)
        out->constraint[i] = sol->constraint[i].expr;
    shadow->space.variable = out->variable;
    shadow->space.variables = sys->variables;
    shadow->space.parameter = sys->parameter;
    shadow->space.constraint = out->constraint;
    shadow->space.constraints = sol->constraints;
    shadow->space.near = NULL;
    shadow->space.before = NULL;
}

bool structure_find(const struct sys_system *sys, const struct sga_solution *sol, struct points_shadow *shadow,
                    const struct sga_budget *budget, struct structure *out, struct sga_error *err)
{
    struct structure_work w = { .sys = sys, .sol = sol, .shadow = shadow, .budget = budget };
    *out = (struct structure){ 0 };
    work_init(&w, sys);
    space_of(sys, sol, shadow, out);
    if (sol->verdict != SGA_INCONSISTENT) {
        structure_initial(&w, out);
        structure_equations(&w, out);
    }
    if (sga_budget_ok(budget, err))
        structure_blocks(&w, out);
    points_shadow_clear(&w.space);
    expr_cone_clear(&w.cone);
    free(w.column);
    free(w.active);
    if (!expr_store_ok(sys->store)) {
        *err = sys->store->error;
        return false;
    }
    return sga_budget_ok(budget, err);
}

void structure_clear(struct structure *s)
{
    free(s->variable);
    free(s->constraint);
    free(s->free_initial);
    free(s->solved_for);
    for (int i = 0; i < s->equations; i++)
        free(s->equation[i].part);
    free(s->equation);
    free(s->block);
    free(s->matched);
    free(s->motion.first);
    free(s->motion.member);
    free(s->motion_group);
    free(s->need_first);
    free(s->need);
    free(s->row_part);
    free(s->col_part);
}
