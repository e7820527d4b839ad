/* A function written on the present set with fewer variables: constraints that are solved
 * by one variable with a constant factor are used up. */
#include "regular.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"

/* The variable that e is solved for, and its constant factor; -1 if there is none. */
static int solved_symbol(struct state *s, expr_id e, expr_id *slope)
{
    SGA_RESERVE(s->active, s->active_cap, s->st->symbols);
    memset(s->active, 0, (size_t)s->st->symbols);
    for (int j = 0; j < s->sys->variables; j++)
        s->active[s->variable[j]] = 1;
    struct expr_term *term = NULL;
    size_t cap = 0;
    int n = expr_gradient(s->st, &s->cone, e, s->active, &term, &cap), found = -1;
    for (int k = 0; k < n && found < 0; k++) {
        /* the slope may only look as if it depended on something: its normal form tells */
        struct poly_limits limits = { .max_terms = 100, .max_generators = 24, .budget = s->options->budget };
        expr_id v = term[k].value;
        poly_normal(s->st, v, &limits, &v);
        unsigned f = expr_facts_of(&s->facts, s->st, v);
        if (expr_is_zero(s->st, v) || (f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
            continue;
        found = term[k].symbol;
        *slope = v;
    }
    free(term);
    return found;
}

bool regular_is_solved(struct state *s, expr_id e)
{
    expr_id slope;
    struct regular r = regular_form(s, e);
    bool solved = r.options == 1 && r.option[0].count == 1 && solved_symbol(s, r.option[0].out[0], &slope) >= 0;
    regular_clear(&r);
    return solved;
}

expr_id regular_reduced(struct state *s, expr_id e)
{
    int own = s->sol->constraints, c = own + s->pendings, symbols = s->st->symbols;
    expr_id *map = sga_calloc((size_t)symbols, sizeof *map);
    expr_id *left = sga_malloc((size_t)(c + 1) * sizeof *left), *normal = sga_malloc((size_t)(c + 1) * sizeof *normal);
    struct poly_limits limits = { .max_terms = 400, .max_generators = 24, .budget = s->options->budget };
    if (own)
        memcpy(left, s->con, (size_t)own * sizeof *left);
    for (int i = own; i < c; i++)
        left[i] = s->pending[i - own];
    left[c] = e;
    for (int i = 0; i < c; i++) {
        expr_id slope;
        int x = solved_symbol(s, left[i], &slope);
        if (x < 0)
            continue;
        memset(map, 0, (size_t)symbols * sizeof *map);
        map[x] = expr_sub(s->st, s->st->symbol[x].node, expr_div(s->st, left[i], slope));
        poly_normal(s->st, map[x], &limits, &map[x]);
        expr_substitute(s->st, left + i + 1, c - i, map);
        poly_normal_all(s->st, left + i + 1, c - i, &limits, normal);
        memcpy(left + i + 1, normal, (size_t)(c - i) * sizeof *left);
    }
    e = left[c];
    free(map);
    free(left);
    free(normal);
    return e;
}
