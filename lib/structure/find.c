/* The stages of the structure, on one finished reduction. */
#include "structure_work.h"

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

bool structure_find(const struct sys_system *sys, const struct sga_solution *sol, struct points_shadow *shadow,
                    const struct sga_budget *budget, struct structure *out, struct sga_error *err)
{
    struct structure_work w = { .sys = sys, .sol = sol, .shadow = shadow, .budget = budget };
    *out = (struct structure){ 0 };
    work_init(&w, sys);
    if (sol->verdict != SGA_INCONSISTENT) {
        structure_initial(&w, out);
        structure_equations(&w, out);
    }
    if (sga_budget_ok(budget, err))
        structure_blocks(&w, out);
    if (sol->verdict != SGA_INCONSISTENT && sga_budget_ok(budget, err)) {
        structure_origins(&w, out);
        structure_follow(&w, out);
    }
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
    free(s->free_initial);
    free(s->solved_for);
    for (int i = 0; i < s->equations; i++)
        free(s->equation[i].part);
    free(s->equation);
    free(s->block);
    free(s->origin);
    free(s->origin_first);
    free(s->origin_unknown);
    free(s->follow);
    free(s->follow_first);
    free(s->matched);
    free(s->motion.first);
    free(s->motion.member);
    free(s->motion_group);
    free(s->need_first);
    free(s->need);
    free(s->row_part);
    free(s->col_part);
}
