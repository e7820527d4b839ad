/* What the reader of implicit equations needs: unknowns and their derivatives' symbols. */
#include "equations.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "derivatives.h"
#include "derive.h"
#include "mem.h"
#include "signal.h"

void form_equations_init(struct form_equations *f, struct expr_store *st)
{
    *f = (struct form_equations){ .store = st };
}

void form_equations_clear(struct form_equations *f)
{
    free(f->unknown);
    free(f->equation);
    free(f->owner);
    free(f->rank);
    *f = (struct form_equations){ 0 };
}

/* Symbols may be added to the store by others: they belong to no unknown. */
static void note(struct form_equations *f, int symbol, int unknown, int rank)
{
    if (symbol >= f->known) {
        int n = symbol + 1 > 2 * f->known ? symbol + 1 : 2 * f->known;
        f->owner = sga_realloc(f->owner, (size_t)n * sizeof *f->owner);
        f->rank = sga_realloc(f->rank, (size_t)n * sizeof *f->rank);
        for (int i = f->known; i < n; i++)
            f->owner[i] = -1;
        f->known = n;
    }
    f->owner[symbol] = unknown;
    f->rank[symbol] = rank;
}

void form_equations_unknown(struct form_equations *f, int symbol)
{
    SGA_RESERVE(f->unknown, f->unknown_cap, f->unknowns + 1);
    struct form_unknown *u = f->unknown + f->unknowns;
    *u = (struct form_unknown){ 0 };
    for (int k = 0; k <= FORM_MAX_ORDER; k++)
        u->symbol[k] = -1;
    u->symbol[0] = symbol;
    note(f, symbol, f->unknowns++, 0);
}

/* The symbol of derivative `order` of unknown u, made where it is missing; -1 on the
 * store's error. */
int form_derivative_symbol(struct form_equations *f, int u, int order)
{
    assert(u >= 0 && u < f->unknowns && order >= 0 && order <= FORM_MAX_ORDER);
    int *symbol = &f->unknown[u].symbol[order];
    if (*symbol >= 0)
        return *symbol;
    SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
    sga_buf_puts(&name, f->store->symbol[f->unknown[u].symbol[0]].name);
    for (int k = 0; k < order; k++)
        sga_buf_put(&name, "'", 1);
    expr_id e = expr_symbol_add(f->store, name.data, EXPR_VELOCITY);
    if (!e)
        return -1;
    *symbol = f->store->node[e].a;
    note(f, *symbol, u, order);
    return *symbol;
}

expr_id form_equations_derivative(void *ctx, int symbol, int order)
{
    struct form_equations *f = ctx;
    if (symbol >= f->known || f->owner[symbol] < 0 || f->rank[symbol] || order > FORM_MAX_ORDER)
        return EXPR_UNDEF;
    int s = form_derivative_symbol(f, f->owner[symbol], order);
    return s < 0 ? EXPR_UNDEF : f->store->symbol[s].node;
}

expr_id form_equations_total(void *ctx, expr_id e)
{
    struct form_equations *f = ctx;
    struct expr_store *st = f->store;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    SGA_FREED unsigned char *active = sga_calloc((size_t)st->symbols + 1, 1);
    for (int i = 0; i < st->symbols; i++)
        active[i] = i < f->known && f->owner[i] >= 0;
    expr_cone_init(&cone);
    int terms = expr_gradient(st, &cone, e, active, &term, &cap);
    int time = -1;
    for (int i = 0; i < st->symbols && time < 0; i++)
        time = st->symbol[i].kind == EXPR_TIME ? i : -1;
    expr_id sum = expr_time_partial(st, e, time);
    for (int k = 0; k < terms && sum; k++) {
        int s = term[k].symbol, order = f->rank[s] + 1;
        int next = order > FORM_MAX_ORDER ? -1 : form_derivative_symbol(f, f->owner[s], order);
        sum = next < 0 ? EXPR_UNDEF : expr_add(st, sum, expr_mul(st, term[k].value, st->symbol[next].node));
    }
    return sum;
}

void form_equations_add(struct form_equations *f, expr_id left_minus_right)
{
    SGA_RESERVE(f->equation, f->equation_cap, f->equations + 1);
    f->equation[f->equations++] = left_minus_right;
}
