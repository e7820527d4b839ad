/* The stages of the structure, on one finished reduction. */
#include "structure_work.h"

#include <assert.h>
#include <stdlib.h>

#include "budget.h"
#include "error.h"
#include "oracle.h"
#include "reduction.h"
#include "structure.h"
#include "system.h"

static void work_init(struct structure_work *w, const struct sys_system *sys)
{
    expr_cone_init(&w->cone);
    points_oracle_init(&w->space, 20250711);
    w->symbols = sys->store->symbols;
    w->column = sga_take(&w->mem, ((size_t)w->symbols + 1) * sizeof *w->column);
    w->active = sga_zeros(&w->mem, (size_t)w->symbols + 1, 1);
    for (int i = 0; i < w->symbols; i++)
        w->column[i] = -1;
    for (int j = 0; j < sys->variables; j++) {
        w->column[sys->variable[j].symbol] = j;
        w->active[sys->variable[j].symbol] = 1;
    }
}

static void work_clear(struct structure_work *w)
{
    points_oracle_clear(&w->space);
    expr_cone_clear(&w->cone);
    sga_arena_end(&w->mem);
}

bool structure_sane(const struct sys_system *sys, const struct sga_solution *sol, const struct structure *s)
{
    bool sane = s->equations == 0 || s->equations == sys->rows + sol->constraints;
    for (int j = 0; j < sys->variables && sane && s->block; j++)
        sane = s->block[j] < s->blocks && (s->block[j] < 0 || (s->matched[j] >= 0 && s->matched[j] < s->equations));
    for (int i = 0; i < sol->constraints && sane && s->has_initial; i++)
        sane = s->solved_for[i] >= 0 && s->solved_for[i] < sys->variables;
    for (int b = 0; b < s->blocks && sane && s->origin_first; b++)
        sane = s->origin_first[b] <= s->origin_first[b + 1];
    return sane && (!s->has_initial || s->frees == sys->variables - sol->constraints);
}

bool structure_find(const struct sys_system *sys, const struct sga_solution *sol, struct points_oracle *oracle,
                    const struct sga_budget *budget, struct structure *out, struct sga_error *err)
{
    struct structure_work w = { .sys = sys, .sol = sol, .oracle = oracle, .budget = budget };
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
    assert(structure_sane(sys, sol, out));
    work_clear(&w);
    if (!expr_store_ok(sys->store)) {
        *err = *sys->store->error;
        return false;
    }
    return sga_budget_ok(budget, err);
}

void structure_clear(struct structure *s)
{
    sga_arena_end(&s->mem);
}
