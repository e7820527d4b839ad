/* Derivatives of expressions along the directions of a variation. */
#include "variation_along.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "system.h"
#include "variation.h"

expr_id *along_symbols(const struct sys_system *sys, const struct variation_by *by, int directions)
{
    struct expr_store *st = sys->store;
    size_t n = (size_t)sys->variables;
    expr_id *slope = sga_calloc((size_t)directions * n + 1, sizeof *slope);
    for (int d = 0; d < directions; d++)
        for (size_t j = 0; j < n && expr_store_ok(st); j++) {
            char name[400];
            const char *x = st->symbol[sys->variable[j].symbol].name;
            if (by[d].parameter >= 0)
                snprintf(name, sizeof name, "d(%.150s)/d(%.150s)", x, st->symbol[by[d].parameter].name);
            else
                snprintf(name, sizeof name, "d(%.150s)/d(start %d)", x, by[d].variable);
            int old = expr_symbol_find(st, name, strlen(name));
            slope[(size_t)d * n + j] = old >= 0 ? st->symbol[old].node : expr_symbol_add(st, name, EXPR_VARIABLE);
        }
    return slope;
}

void along_begin(struct variation_along *a, const struct sys_system *sys, const struct variation_by *by, int directions, const expr_id *slope)
{
    struct expr_store *st = sys->store;
    *a = (struct variation_along){ .st = st, .sys = sys, .by = by, .directions = directions, .slope = slope,
                         .variable_of = sga_malloc(((size_t)st->symbols + 1) * sizeof *a->variable_of), .active = sga_calloc((size_t)st->symbols + 1, 1) };
    expr_cone_init(&a->cone);
    for (int s = 0; s < st->symbols; s++)
        a->variable_of[s] = -1;
    for (int j = 0; j < sys->variables; j++) {
        a->variable_of[sys->variable[j].symbol] = j;
        a->active[sys->variable[j].symbol] = 1;
    }
    for (int d = 0; d < directions; d++)
        if (by[d].parameter >= 0)
            a->active[by[d].parameter] = 1;
}

void along_end(struct variation_along *a)
{
    expr_cone_clear(&a->cone);
    free(a->variable_of);
    free(a->active);
    free(a->term);
}

void along_of(struct variation_along *a, expr_id e, expr_id *to)
{
    struct expr_store *st = a->st;
    int terms = expr_gradient(st, &a->cone, e, a->active, &a->term, &a->cap);
    for (int d = 0; d < a->directions; d++) {
        to[d] = expr_int(st, 0);
        for (int k = 0; k < terms; k++) {
            int j = a->variable_of[a->term[k].symbol];
            if (j >= 0)
                to[d] = expr_add(st, to[d], expr_mul(st, a->term[k].value, a->slope[(size_t)d * (size_t)a->sys->variables + (size_t)j]));
            else if (a->term[k].symbol == a->by[d].parameter)
                to[d] = expr_add(st, to[d], a->term[k].value);
        }
    }
}
