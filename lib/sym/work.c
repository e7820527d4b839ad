/* Derivatives along fields, brackets, and the part of a vector outside the gauge fields. */
#include "sym_work.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "derive.h"
#include "mem.h"
#include "oracle.h"
#include "poly.h"
#include "reduction.h"
#include "system.h"

expr_id sym_derive(struct sym_work *w, const expr_id *D, expr_id f)
{
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    expr_id sum = expr_int(w->st, 0);
    int count = expr_gradient(w->st, &w->cone, f, w->active, &term, &cap);
    for (int k = 0; k < count; k++)
        sum = expr_add(w->st, sum, expr_mul(w->st, D[w->column[term[k].symbol]], term[k].value));
    return sum;
}

void sym_bracket(struct sym_work *w, const expr_id *D, const expr_id *Y, expr_id *out)
{
    struct expr_store *st = w->st;
    expr_id slow = sym_derive(w, Y, D[w->n]);
    for (int a = 0; a < w->n; a++)
        out[a] = expr_add(st, expr_sub(st, sym_derive(w, D, Y[a]), sym_derive(w, Y, D[a])),
                          expr_mul(st, slow, w->field[a]));
}

void sym_modulo_gauge(struct sym_work *w, const expr_id *gauge, expr_id *v)
{
    assert(w->gauges <= w->sol->free_columns);
    struct expr_store *st = w->st;
    for (int k = 0; k < w->gauges; k++) {
        expr_id part = v[w->sol->free_column[k]];
        const expr_id *K = gauge + (size_t)k * (size_t)(w->n + 1);
        if (expr_is_zero(st, part))
            continue;
        for (int a = 0; a < w->n; a++)
            if (!w->is_free[a])
                v[a] = expr_sub(st, v[a], expr_mul(st, part, K[a]));
    }
    for (int k = 0; k < w->gauges; k++)
        v[w->sol->free_column[k]] = expr_int(st, 0);
}

enum sym_truth sym_and(enum sym_truth a, enum sym_truth b)
{
    if (a == SYM_FALSE || b == SYM_FALSE)
        return SYM_FALSE;
    return a == SYM_UNKNOWN || b == SYM_UNKNOWN ? SYM_UNKNOWN : SYM_TRUE;
}

enum sym_truth sym_zero(struct sym_work *w, expr_id e)
{
    if (expr_is_zero(w->st, e))
        return SYM_TRUE;
    if (e == EXPR_UNDEF || !w->oracle->reals)
        return SYM_UNKNOWN;
    struct points_decision d = points_oracle_zero(w->oracle, e);
    return d.truth == POINTS_ZERO ? SYM_TRUE : d.truth == POINTS_NONZERO ? SYM_FALSE : SYM_UNKNOWN;
}

enum sym_truth sym_all_zero(struct sym_work *w, const expr_id *e, int n, expr_id *defect)
{
    enum sym_truth all = SYM_TRUE;
    for (int i = 0; i < n && all != SYM_FALSE; i++) {
        enum sym_truth here = sga_budget_ok(w->budget, NULL) ? sym_zero(w, e[i]) : SYM_UNKNOWN;
        if (here != SYM_TRUE && (all == SYM_TRUE || here == SYM_FALSE))
            *defect = e[i];
        all = sym_and(all, here);
    }
    return all;
}

enum sym_truth sym_note(struct sym_work *w, struct sym_check *c, const char *condition, expr_id e, enum sym_truth truth)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, w->budget);
    if (truth != SYM_TRUE && c->defects < SYM_DEFECTS) {
        if (e != EXPR_UNDEF)
            poly_normal(w->st, e, &limits, &e);
        c->defect[c->defects++] = (struct sym_defect){ condition, e, truth == SYM_FALSE };
    }
    assert(c->defects <= SYM_DEFECTS);
    return truth;
}

expr_id sym_entry(struct sym_work *w, int i, int j)
{
    assert(i >= 0 && i < w->sys->rows && j < w->n);
    const struct sys_row *r = w->sys->row + i;
    for (int k = 0; k < r->entries; k++)
        if (r->entry[k].col == j)
            return r->entry[k].value;
    return expr_int(w->st, 0);
}

/* The reduction is over, and so are the arrays that its oracle knew. */
static void set_space(struct sym_work *w)
{
    const struct sga_solution *sol = w->sol;
    w->variable = sga_take(&w->mem, ((size_t)w->n + 1) * sizeof *w->variable);
    w->constraint = sga_take(&w->mem, ((size_t)sol->constraints + 1) * sizeof *w->constraint);
    for (int j = 0; j < w->n; j++)
        w->variable[j] = w->sys->variable[j].symbol;
    for (int i = 0; i < sol->constraints; i++)
        w->constraint[i] = sol->constraint[i].expr;
    struct points_space *space = &w->oracle->space;
    space->variable = w->variable;
    space->variables = w->n;
    space->parameter = w->sys->parameter;
    space->constraint = w->constraint;
    space->constraints = sol->constraints;
    space->near = NULL;
    space->before = NULL;
}

static void set_fields(struct sym_work *w)
{
    size_t n = (size_t)w->n;
    w->gauges = w->sol->gauge ? w->sol->free_columns : 0;
    w->field = sga_take(&w->mem, (n + 1) * sizeof *w->field);
    w->gauge = sga_take(&w->mem, (n + 1) * (size_t)(w->gauges + 1) * sizeof *w->gauge);
    w->is_free = sga_zeros(&w->mem, n + 1, 1);
    for (size_t a = 0; a < n; a++)
        w->field[a] = w->sol->field ? w->sol->field[a] : expr_int(w->st, 0);
    w->field[n] = expr_int(w->st, 1);
    for (int k = 0; k < w->gauges; k++) {
        memcpy(w->gauge + (n + 1) * (size_t)k, w->sol->gauge + n * (size_t)k, n * sizeof *w->gauge);
        w->gauge[(n + 1) * (size_t)k + n] = expr_int(w->st, 0);
        w->is_free[w->sol->free_column[k]] = 1;
    }
}

struct sym_work *sym_new(const struct sys_system *sys, const struct sga_solution *sol, struct points_oracle *oracle,
                         const struct sga_budget *budget, bool tensor)
{
    struct sym_work *w = sga_calloc(1, sizeof *w);
    *w = (struct sym_work){ .sys = sys, .sol = sol, .oracle = oracle, .budget = budget, .st = sys->store,
                            .n = sys->variables, .tensor = tensor && sys->rows == sys->variables };
    size_t symbols = (size_t)w->st->symbols + 1;
    expr_cone_init(&w->cone);
    w->active = sga_zeros(&w->mem, symbols, 1);
    w->column = sga_zeros(&w->mem, symbols, sizeof *w->column);
    for (int j = 0; j < w->n; j++) {
        w->active[sys->variable[j].symbol] = 1;
        w->column[sys->variable[j].symbol] = j;
    }
    w->active[sys->time] = 1;
    w->column[sys->time] = w->n;
    set_space(w);
    set_fields(w);
    return w;
}

void sym_free(struct sym_work *w)
{
    if (!w)
        return;
    expr_cone_clear(&w->cone);
    sga_arena_end(&w->mem);
    free(w);
}
