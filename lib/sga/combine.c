/* Which combination of equations and tangencies made a constraint. */
#include "state.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "expr_rows.h"
#include "mem.h"
#include "reduction.h"
#include "system.h"

static void add_part(struct state *s, struct sga_part **part, int *parts, size_t *cap, int source, expr_id factor)
{
    if (source < 0 || expr_is_zero(s->st, factor))
        return;
    SGA_RESERVE(*part, *cap, *parts + 1);
    int rows = s->sys->rows;
    (*part)[(*parts)++] = (struct sga_part){ .row = source < rows ? source : -1,
                                             .tangency = source < rows ? -1 : source - rows, .factor = factor };
}

/* The pivot rows of a dense block are S^-1 times their sources: weights w on them are weights
 * S^-T w on the latter. */
static void through_block(struct state *s, const struct ech_dense *b, expr_id *weight)
{
    assert(b->first + b->size <= s->ech.pivots);
    int r = b->size;
    bool any = false;
    for (int k = 0; k < r; k++)
        any |= weight[b->first + k] != EXPR_UNDEF;
    if (!any)
        return;
    SGA_ENDS(expr_rows_clear) struct expr_rows T = expr_rows_transposed(&b->matrix, r, r);
    SGA_FREED expr_id *w = sga_malloc((size_t)r * sizeof *w);
    for (int k = 0; k < r; k++)
        w[k] = weight[b->first + k] ? weight[b->first + k] : expr_int(s->st, 0);
    int solve = expr_solve_add_rows(s->st, r, &T, w);
    for (int k = 0; k < r; k++)
        weight[b->first + k] = expr_solution(s->st, solve, k);
}

/* Weights on pivot rows as weights on sources, which become parts: a pivot row is its source minus the sum of factor * earlier pivot row, so
 * that one sweep from the last pivot to the first does it. */
static void sweep(struct state *s, expr_id *weight, struct sga_part **part, int *parts, size_t *cap)
{
    struct expr_store *st = s->st;
    int block = s->ech.blocks - 1;
    for (int q = s->ech.pivots - 1; q >= 0; q--) {
        for (; block >= 0 && s->ech.block[block].first + s->ech.block[block].size - 1 > q; block--)
            ;
        if (block >= 0 && s->ech.block[block].first + s->ech.block[block].size - 1 == q)
            through_block(s, s->ech.block + block, weight);
        if (!weight[q])
            continue;
        const struct ech_row *r = &s->ech.pivot[q].row;
        add_part(s, part, parts, cap, r->source, weight[q]);
        for (int k = 0; k < r->ops; k++) {
            expr_id t = expr_mul(st, weight[q], r->op[k].factor);
            expr_id *w = weight + r->op[k].pivot;
            *w = *w ? expr_sub(st, *w, t) : expr_neg(st, t);
        }
    }
}

void state_combine_pivot(struct state *s, int pivot, struct sga_part **part, int *parts)
{
    assert(pivot >= 0 && pivot < s->ech.pivots);
    size_t cap = 0;
    *part = NULL;
    *parts = 0;
    SGA_FREED expr_id *weight = sga_calloc((size_t)s->ech.pivots, sizeof *weight);
    weight[pivot] = expr_int(s->st, 1);
    sweep(s, weight, part, parts, &cap);
}

/* A row is its source minus the sum of factor * pivot row. */
void state_combine(struct state *s, const struct candidate *c, struct sga_part **part, int *parts)
{
    struct expr_store *st = s->st;
    size_t cap = 0;
    *part = NULL;
    *parts = 0;
    add_part(s, part, parts, &cap, c->source, c->times ? c->times : expr_int(st, 1));
    if (!c->ops)
        return;
    SGA_FREED expr_id *weight = sga_calloc((size_t)s->ech.pivots, sizeof *weight);
    for (int k = 0; k < c->ops; k++) {
        assert(c->op[k].pivot < s->ech.pivots);
        expr_id *w = weight + c->op[k].pivot, f = c->times ? expr_mul(st, c->times, c->op[k].factor) : c->op[k].factor;
        *w = *w ? expr_sub(st, *w, f) : expr_neg(st, f);
    }
    sweep(s, weight, part, parts, &cap);
}
