/* The reduced vector field and the gauge fields, by back substitution. */
#include "state.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "derive.h"
#include "facts.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "system.h"
#include "warnings.h"

/* v_j for every pivot column, given v on the free columns; rhs counted with factor 0 or 1. False: the store has more
 * nodes than `most` (0: no limit). */
static bool back_substitute(struct state *s, expr_id *v, bool inhomogeneous, int most)
{
    struct expr_store *st = s->st;
    for (int q = s->ech.pivots - 1; q >= 0; q--) {
        const struct ech_pivot *p = s->ech.pivot + q;
        if (s->determined[p->col]) {
            v[p->col] = inhomogeneous ? s->flow->velocity[s->variable[p->col]] : expr_int(st, 0);
            continue;
        }
        expr_id x = inhomogeneous ? p->row.rhs : expr_int(st, 0);
        for (int k = 0; k < p->row.entries; k++)
            if (p->row.entry[k].col != p->col)
                x = expr_sub(st, x, expr_mul(st, p->row.entry[k].value, v[p->row.entry[k].col]));
        v[p->col] = expr_div(st, x, p->value);
        if (most && st->nodes > most)
            return false;
    }
    return true;
}

/* Components of gauge fields for each node that they may add: most are 0, but there is a list of all. */
enum { COMPONENTS = 100 };

/* All of them, or none. */
static void gauge_fields(struct state *s)
{
    struct sga_solution *sol = s->sol;
    int n = s->sys->variables, room = s->options->gauge_nodes, most = room ? s->st->nodes + room : 0;
    bool ok = true;
    if (room && (double)sol->free_columns * n > (double)COMPONENTS * room)
        return;
    sol->gauge = sga_malloc((size_t)sol->free_columns * (size_t)n * sizeof *sol->gauge);
    for (int f = 0; f < sol->free_columns && ok; f++) {
        expr_id *z = sol->gauge + (size_t)f * (size_t)n;
        for (int j = 0; j < n; j++)
            z[j] = expr_int(s->st, j == sol->free_column[f]);
        ok = back_substitute(s, z, false, most);
    }
    if (ok)
        return;
    free(sol->gauge);
    sol->gauge = NULL;
}

/* Fields of so many nodes are looked at for sums that cancel; normal forms take their place where these have so much fewer nodes all together, or are
 * divided by fewer functions and have so many more at the most. */
enum { LEAST = 20, MOST = 2000, SMALLER = 2, MORE = 20 };

/* By how many different functions that may vanish the field divides; 0 where it is too large to be looked at. */
static int divisors(struct state *s, const expr_id *field, int n, int *nodes)
{
    SGA_FREED expr_id *seen = NULL;
    size_t cap = 0;
    int count = 0;
    expr_cone_of(s->st, &s->cone, field, n);
    *nodes = s->cone.count;
    for (int k = 0; k < s->cone.count && *nodes <= MOST; k++) {
        expr_id below = expr_divisor(s->st, s->cone.list[k]);
        bool is_new = below && !(state_facts(s, below) & EXPR_NONZERO);
        for (int i = 0; i < count && is_new; i++)
            is_new = seen[i] != below;
        if (is_new) {
            SGA_RESERVE(seen, cap, count + 1);
            seen[count++] = below;
        }
    }
    return count;
}

/* Whether elimination divided by a function that may vanish. */
static bool divided(struct state *s)
{
    bool any = false;
    for (int q = 0; q < s->ech.pivots && !any; q++)
        any = !(state_facts(s, s->ech.pivot[q].value) & EXPR_NONZERO);
    return any;
}

/* Elimination divides by what cancels in the end, and leaves sums that do: numbers that are computed as it stands have no value, or fewer digits,
 * where such a function is small. */
static void in_normal_form(struct state *s, expr_id *field, int n)
{
    int nodes, poles, left, small;
    if (s->ech.blocks || n > MOST / LEAST || !divided(s))
        return;
    poles = divisors(s, field, n, &nodes);
    if (!poles || nodes < LEAST)
        return;
    struct poly_limits limits = poly_limits_of(POLY_MODEST, s->options->budget);
    SGA_FREED expr_id *normal = sga_malloc(((size_t)n + 1) * sizeof *normal);
    for (int j = 0; j < n; j++) {
        normal[j] = field[j];
        if (state_size(s, field[j]) >= LEAST)
            poly_normal(s->st, field[j], &limits, normal + j);
    }
    left = divisors(s, normal, n, &small);
    if (SMALLER * small <= nodes || (left < poles && small <= MOST && small <= nodes + nodes / 4 + MORE))
        memcpy(field, normal, (size_t)n * sizeof *normal);
}

void state_fields(struct state *s)
{
    struct sga_solution *sol = s->sol;
    int n = s->sys->variables;
    sol->free_column = sga_malloc((size_t)n * sizeof *sol->free_column);
    for (int j = 0; j < n; j++)
        if (s->ech.pivot_of[j] < 0)
            sol->free_column[sol->free_columns++] = j;
    assert(sol->free_columns == n - s->ech.pivots);
    sol->field = sga_malloc((size_t)n * sizeof *sol->field);
    for (int j = 0; j < n; j++)
        sol->field[j] = expr_int(s->st, 0);
    back_substitute(s, sol->field, true, 0);
    in_normal_form(s, sol->field, n);
    if (s->options->gauge_fields && sol->free_columns)
        gauge_fields(s);
}
