/* What becomes of the rows of a dense block: solutions as SOLVE nodes. */
#include "block_parts.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "expr_rows.h"
#include "mem.h"
#include "system.h"

/* Of a block whose pivots are chosen. */
struct chosen {
    struct expr_rows S;            /* rank x rank, in the order of the pivots */
    struct expr_rows column;       /* the transposed block */
    int *row_place, *col_place;    /* by row and column of the block: which pivot, or -1 */
    struct ech_op *part; int parts;   /* of a row: its entries in chosen columns, in the order of the pivots */
    int *solve;                    /* by column of the block, then the right sides: S^-1 times them, or -1 where they are 0 */
};

static void parts_of(struct chosen *w, const struct block *b, int i)
{
    w->parts = 0;
    for (int k = b->at.start[i]; k < b->at.start[i + 1]; k++) {
        int place = w->col_place[b->at.column[k]], q = w->parts;
        if (place < 0)
            continue;
        for (; q > 0 && w->part[q - 1].pivot > place; q--)
            w->part[q] = w->part[q - 1];
        w->part[q] = (struct ech_op){ place, b->at.entry[k] };
        w->parts++;
    }
}

static void chosen_init(struct chosen *w, const struct block *b)
{
    int entries = 0;
    *w = (struct chosen){ .column = expr_rows_transposed(&b->at, b->m, b->n) };
    w->row_place = sga_malloc(((size_t)b->m + 1) * sizeof *w->row_place);
    w->col_place = sga_malloc(((size_t)b->n + 1) * sizeof *w->col_place);
    w->part = sga_malloc(((size_t)b->rank + 1) * sizeof *w->part);
    w->solve = sga_malloc(((size_t)b->n + 1) * sizeof *w->solve);
    memset(w->row_place, -1, (size_t)b->m * sizeof *w->row_place);
    memset(w->col_place, -1, (size_t)b->n * sizeof *w->col_place);
    for (int k = 0; k < b->rank; k++) {
        w->row_place[b->rows[k]] = w->col_place[b->cols[k]] = k;
        entries += b->at.start[b->rows[k] + 1] - b->at.start[b->rows[k]];
    }
    w->S = expr_rows_new(b->rank, entries);
    entries = 0;
    for (int i = 0; i < b->rank; i++) {
        parts_of(w, b, b->rows[i]);
        for (int q = 0; q < w->parts; q++) {
            w->S.column[entries] = w->part[q].pivot;
            w->S.entry[entries++] = w->part[q].factor;
        }
        w->S.start[i + 1] = entries;
    }
}

static void chosen_clear(struct chosen *w)
{
    expr_rows_clear(&w->S);
    expr_rows_clear(&w->column);
    free(w->row_place);
    free(w->col_place);
    free(w->part);
    free(w->solve);
}

/* S^-1 times a column (block column j, or the right sides for j = n): a solve's index, or -1 where the column is 0. */
static int solve_for(const struct block *b, const struct chosen *w, const struct ech_context *c, const struct ech_row *row, const int *index, int j)
{
    SGA_FREED expr_id *r = sga_malloc((size_t)b->rank * sizeof *r);
    bool any = false;
    assert(b->rank > 0 && b->rank <= b->m && b->rank <= b->n);
    for (int k = 0; k < b->rank; k++) {
        expr_id v = j < b->n ? EXPR_UNDEF : row[index[b->rows[k]]].rhs;
        r[k] = v ? v : expr_int(c->st, 0);
    }
    for (int q = j < b->n ? w->column.start[j] : 0; j < b->n && q < w->column.start[j + 1]; q++)
        if (w->row_place[w->column.column[q]] >= 0)
            r[w->row_place[w->column.column[q]]] = w->column.entry[q];
    for (int k = 0; k < b->rank; k++)
        any |= !expr_is_zero(c->st, r[k]);
    return any ? expr_solve_add_rows(c->st, b->rank, &w->S, r) : -1;
}

/* value - sum over the chosen columns of the row's entries times the solution */
static expr_id left_over(const struct chosen *w, const struct ech_context *c, expr_id value, int solve)
{
    expr_id x = value ? value : expr_int(c->st, 0);
    for (int k = 0; k < w->parts && solve >= 0; k++)
        x = expr_sub(c->st, x, expr_mul(c->st, w->part[k].factor, expr_solution(c->st, solve, w->part[k].pivot)));
    return x;
}

bool block_rewrite(struct block *b, struct echelon *e, const struct ech_context *c, struct ech_row *row, const int *index, int generation)
{
    int r = b->rank, first = e->pivots;
    SGA_ENDS(chosen_clear) struct chosen w;
    chosen_init(&w, b);
    for (int j = 0; j <= b->n; j++)
        w.solve[j] = j < b->n && b->col_used[j] ? -1 : solve_for(b, &w, c, row, index, j);
    bool ok = true;
    for (int i = 0; i < b->m && ok; i++) {          /* the dependent rows first: they need the old entries */
        if (b->row_used[i])
            continue;
        struct ech_row *t = row + index[i];
        t->entries = 0;
        parts_of(&w, b, i);
        for (int j = 0; j < b->n && ok; j++) {
            if (b->col_used[j])
                continue;
            expr_id v = left_over(&w, c, expr_rows_at(&b->at, i, j), w.solve[j]);
            int z = ech_zero(c, v);
            ok = z >= 0 && sga_budget_ok(c->budget, c->err);
            if (z == 0)
                ech_row_push(t, b->col[j], v);
        }
        t->rhs = left_over(&w, c, t->rhs, w.solve[b->n]);
        for (int k = 0; k < w.parts && c->record; k++) {
            SGA_RESERVE(t->op, t->op_cap, t->ops + 1);
            t->op[t->ops++] = (struct ech_op){ first + w.part[k].pivot, w.part[k].factor };
        }
    }
    for (int k = 0; k < r && ok; k++) {
        struct ech_row *t = row + index[b->rows[k]];
        t->entries = 0;
        ech_row_push(t, b->col[b->cols[k]], expr_int(c->st, 1));
        for (int j = 0; j < b->n; j++)
            if (w.solve[j] >= 0)
                ech_row_push(t, b->col[j], expr_solution(c->st, w.solve[j], k));
        t->rhs = w.solve[b->n] >= 0 ? expr_solution(c->st, w.solve[b->n], k) : expr_int(c->st, 0);
        SGA_RESERVE(e->pivot, e->pivot_cap, e->pivots + 1);
        e->pivot_of[b->col[b->cols[k]]] = e->pivots;
        e->pivot[e->pivots++] = (struct ech_pivot){ b->col[b->cols[k]], expr_int(c->st, 1), generation, *t };
        *t = (struct ech_row){ 0 };
    }
    if (r) {
        SGA_RESERVE(e->block, e->block_cap, e->blocks + 1);
        e->block[e->blocks++] = (struct ech_dense){ first, r, w.S };
        w.S = (struct expr_rows){ 0 };
    }
    return ok;
}
