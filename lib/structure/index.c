/* The differentiation index of systems of any shape.
 *
 * F = 0, F' = 0, ..., F^(k) = 0 with F = A x' - alpha (and the functions of the restriction) say of (x, x') at points x of Pf that
 * A x' = alpha, and that x' is tangent to P_k: constraints of generation g are consequences of F^(g-1) and what comes before, their
 * derivatives of F^(g). So x' is determined from the first k on for which ker A and T P_k have 0 in common on Pf. This asks for
 * subspaces alone, so it depends neither on the order of the equations nor on which of them are left out as
 * consequences of the others; for square systems it is the number of generations. */
#include "structure.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "derive.h"
#include "echelon.h"
#include "error.h"
#include "facts.h"
#include "mem.h"
#include "oracle.h"
#include "reduction.h"
#include "system.h"

struct asked {
    const struct sys_system *sys;
    const struct sga_solution *sol;
    struct echelon ech;
    struct ech_context ctx;
    struct expr_cone cone;
    int *column;               /* by symbol: variable or -1 */
    unsigned char *active;
};

static void init(struct asked *a, struct expr_facts *facts, struct points_oracle *oracle, const struct sga_budget *budget, struct sga_error *err)
{
    struct expr_store *st = a->sys->store;
    ech_init(&a->ech, a->sys->variables);
    expr_cone_init(&a->cone);
    expr_facts_init(facts);
    a->ctx = (struct ech_context){ .st = st, .facts = facts, .oracle = oracle, .budget = budget, .err = err };
    a->column = sga_malloc(((size_t)st->symbols + 1) * sizeof *a->column);
    a->active = sga_calloc((size_t)st->symbols + 1, 1);
    for (int i = 0; i < st->symbols; i++)
        a->column[i] = -1;
    for (int j = 0; j < a->sys->variables; j++) {
        a->column[a->sys->variable[j].symbol] = j;
        a->active[a->sys->variable[j].symbol] = 1;
    }
}

static void clear(struct asked *a, struct expr_facts *facts)
{
    ech_clear(&a->ech);
    expr_cone_clear(&a->cone);
    expr_facts_clear(facts);
    free(a->column);
    free(a->active);
}

/* The rows of A, or the differentials of the constraints of generation g > 0. */
static struct ech_row *rows_of(struct asked *a, int g, int *count)
{
    struct expr_store *st = a->sys->store;
    struct ech_row *row = sga_calloc((size_t)(g ? a->sol->constraints : a->sys->rows) + 1, sizeof *row);
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    *count = 0;
    for (int i = 0; i < a->sys->rows && !g; i++) {
        struct ech_row *r = row + (*count)++;
        r->rhs = expr_int(st, 0);
        for (int k = 0; k < a->sys->row[i].entries; k++)
            ech_row_push(r, a->sys->row[i].entry[k].col, a->sys->row[i].entry[k].value);
    }
    for (int i = 0; i < a->sol->constraints && g; i++) {
        if (a->sol->constraint[i].generation != g)
            continue;
        struct ech_row *r = row + (*count)++;
        int n = expr_gradient(st, &a->cone, a->sol->constraint[i].expr, a->active, &term, &cap);
        r->rhs = expr_int(st, 0);
        for (int k = 0; k < n; k++)
            ech_row_push(r, a->column[term[k].symbol], term[k].value);
    }
    return row;
}

int structure_index(const struct sys_system *sys, const struct sga_solution *sol, struct points_oracle *oracle,
                    const struct sga_budget *budget)
{
    struct asked a = { .sys = sys, .sol = sol };
    struct expr_facts facts;
    struct sga_error err = { 0 };
    int index = -1;
    bool ok = oracle->reals > 0;
    init(&a, &facts, oracle, budget, &err);
    for (int g = 0; g <= sol->generations && ok && index < 0; g++) {
        int count;
        SGA_FREED struct ech_row *row = rows_of(&a, g, &count);
        ok = ech_eliminate(&a.ech, &a.ctx, row, count, g);
        if (ok && a.ech.pivots == sys->variables)
            index = g;
        for (int i = 0; i < count; i++)
            ech_row_clear(row + i);
    }
    clear(&a, &facts);
    assert(index >= -1);
    return index;
}
