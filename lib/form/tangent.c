/* The kernel of a matrix of expressions: constant pivots first, then block by block. */
#include "cofactors.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "probe.h"

struct elimination {
    struct expr_store *st;
    expr_id *a;
    int rows, cols, rank;
    int *column;               /* of the pivot of row i < rank */
    unsigned char *is_pivot;   /* by column */
    struct form_probe probe;
    const struct form_zero *zero;
    int *block;                /* by column: the first column of its block (union-find) */
    expr_id *out; int count;   /* the vectors; so far over the columns without a constant pivot */
};

static expr_id *row_of(const struct elimination *e, int i)
{
    return e->a + (size_t)i * (size_t)e->cols;
}

/* What is zero is written as the constant 0, so that it makes no block larger. */
static void drop_zeros(struct elimination *e, int from)
{
    for (size_t k = (size_t)from * (size_t)e->cols; k < (size_t)e->rows * (size_t)e->cols; k++)
        if (!expr_is_const(e->st, e->a[k]) && form_probe_zero(&e->probe, e->st, e->a[k]))
            e->a[k] = expr_int(e->st, 0);
}

static bool vanishes(struct elimination *e, expr_id v)
{
    if (expr_is_const(e->st, v))
        return expr_is_zero(e->st, v);
    return e->zero && e->zero->vanishes ? e->zero->vanishes(e->zero->ctx, v) : form_probe_zero(&e->probe, e->st, v);
}

/* A pivot in rows from `rank` to `last` among the columns of a block (-1: of all): a constant, or,
 * unless only those will do, what does not vanish. */
static bool choose(struct elimination *e, int last, int block, bool constant, int *row, int *col)
{
    bool found = false;
    for (int i = e->rank; i < last; i++)
        for (int j = 0; j < e->cols; j++) {
            expr_id v = row_of(e, i)[j];
            bool number = expr_is_const(e->st, v);
            if (e->is_pivot[j] || (block >= 0 && e->block[j] != block) || (!number && (constant || found)) || vanishes(e, v))
                continue;
            *row = i;
            *col = j;
            found = true;
            if (number)
                return true;
        }
    return found;
}

static void swap_rows(struct elimination *e, int i, int k)
{
    for (int j = 0; j < e->cols && i != k; j++) {
        expr_id *x = row_of(e, i) + j, *y = row_of(e, k) + j, t = *x;
        *x = *y;
        *y = t;
    }
}

/* row_i := pivot * row_i - a_ip * row_k; a constant pivot has been made 1. */
static void clear_column(struct elimination *e, int i, int k, int p)
{
    struct expr_store *st = e->st;
    expr_id *x = row_of(e, i), *y = row_of(e, k), factor = x[p], pivot = y[p];
    if (i == k || expr_is_zero(st, factor))
        return;
    for (int j = 0; j < e->cols; j++)
        x[j] = j == p ? expr_int(st, 0)
                      : expr_sub(st, expr_mul(st, pivot, x[j]), expr_mul(st, factor, y[j]));
}

/* One pivot after the other in the rows from rank to last; rows from `first` on are cleared. */
static void eliminate(struct elimination *e, int first, int last, int block, bool constant)
{
    int row = 0, col = 0;
    while (e->rank < last && choose(e, last, block, constant, &row, &col)) {
        int k = e->rank++;
        swap_rows(e, row, k);
        expr_id *y = row_of(e, k), pivot = y[col];
        for (int j = 0; j < e->cols && expr_is_const(e->st, pivot); j++)
            y[j] = expr_div(e->st, y[j], pivot);
        e->column[k] = col;
        e->is_pivot[col] = 1;
        for (int i = first; i < last; i++)
            clear_column(e, i, k, col);
    }
}

static int root(int *block, int j)
{
    while (block[j] != j)
        j = block[j] = block[block[j]];
    return j;
}

/* Columns that stand in one row belong to one block. */
static void find_blocks(struct elimination *e)
{
    for (int j = 0; j < e->cols; j++)
        e->block[j] = j;
    for (int i = e->rank; i < e->rows; i++) {
        int first = -1;
        for (int j = 0; j < e->cols; j++) {
            if (expr_is_zero(e->st, row_of(e, i)[j]))
                continue;
            int r = root(e->block, j);
            if (first < 0)
                first = r;
            else if (r < first) {
                e->block[first] = r;
                first = r;
            } else {
                e->block[r] = first;
            }
        }
    }
    for (int j = 0; j < e->cols; j++)
        e->block[j] = root(e->block, j);
}

static int block_of_row(const struct elimination *e, int i)
{
    for (int j = 0; j < e->cols; j++)
        if (!expr_is_zero(e->st, row_of(e, i)[j]))
            return e->block[j];
    return -1;
}

static expr_id *add_vector(struct elimination *e)
{
    size_t n = (size_t)e->cols;
    e->out = sga_realloc(e->out, ((size_t)(e->count + 1) * n + 1) * sizeof *e->out);
    expr_id *v = e->out + (size_t)e->count++ * n;
    for (size_t j = 0; j < n; j++)
        v[j] = expr_int(e->st, 0);
    return v;
}

/* Rows first..last-1 have been eliminated crosswise:  d x_p + sum r_f x_f = 0 with the pivot d. The vector
 * of the free column f is e_f times the pivots of the rows that have an r_f. */
static void free_vector(struct elimination *e, int f, int first, int last)
{
    struct expr_store *st = e->st;
    expr_id *v = add_vector(e);
    v[f] = expr_int(st, 1);
    for (int i = first; i < last; i++) {
        const expr_id *row = row_of(e, i);
        if (expr_is_zero(st, row[f]))
            continue;
        expr_id scale = v[f], pivot = row[e->column[i]];
        for (int j = 0; j < e->cols; j++)
            v[j] = expr_mul(st, pivot, v[j]);
        v[e->column[i]] = expr_neg(st, expr_mul(st, scale, row[f]));
    }
}

static bool all_vanish(struct elimination *e, int from)
{
    for (size_t k = (size_t)from * (size_t)e->cols; k < (size_t)e->count * (size_t)e->cols; k++)
        if (!vanishes(e, e->out[k]))
            return false;
    return true;
}

/* The vectors of a block whose rows stand from `first` to `last`, over its own columns. */
static void solve_block(struct elimination *e, int block, int first, int last)
{
    SGA_ARENA(mem);
    int *col = sga_take(&mem, ((size_t)e->cols + 1) * sizeof *col), n = 0, before = e->count;
    expr_id **row = sga_take(&mem, ((size_t)(last - first) + 1) * sizeof *row);
    for (int j = 0; j < e->cols; j++)
        if (e->block[j] == block && !e->is_pivot[j])
            col[n++] = j;
    for (int i = first; i < last; i++)
        row[i - first] = row_of(e, i);
    if (last - first > n || !form_cofactors(e->st, row, last - first, col, n, e->cols, &e->out, &e->count)
        || (last - first < n && all_vanish(e, before))) {      /* the last: the rows are dependent */
        e->count = before;
        e->rank = first;
        eliminate(e, first, last, block, false);
        for (int k = 0; k < n; k++)
            if (!e->is_pivot[col[k]])
                free_vector(e, col[k], first, e->rank);
    }
    e->rank = last;
}

/* Blocks one after the other; each draws its rows together. */
static void solve_blocks(struct elimination *e)
{
    int constant = e->rank;
    for (int j = 0; j < e->cols; j++) {
        int first = e->rank, last = first;
        if (e->is_pivot[j] || e->block[j] != j)
            continue;
        for (int i = first; i < e->rows; i++)
            if (block_of_row(e, i) == j)
                swap_rows(e, i, last++);
        if (last > first)
            solve_block(e, j, first, last);
        else
            add_vector(e)[j] = expr_int(e->st, 1);
    }
    e->rank = constant;
}

/* The columns with constant pivots follow from the others: x_p = - sum r_j x_j. */
static void lift(struct elimination *e)
{
    struct expr_store *st = e->st;
    for (int k = 0; k < e->count; k++) {
        expr_id *v = e->out + (size_t)k * (size_t)e->cols;
        for (int i = 0; i < e->rank; i++) {
            const expr_id *row = row_of(e, i);
            expr_id sum = expr_int(st, 0);
            for (int j = 0; j < e->cols; j++)
                if (j != e->column[i])
                    sum = expr_add(st, sum, expr_mul(st, row[j], v[j]));
            v[e->column[i]] = expr_neg(st, sum);
        }
    }
}

expr_id *form_kernel(struct expr_store *st, expr_id *matrix, int rows, int cols, const struct form_zero *zero, int *count)
{
    assert(rows >= 0 && cols > 0);
    struct elimination e = { .st = st, .a = matrix, .rows = rows, .cols = cols, .zero = zero };
    e.column = sga_calloc((size_t)rows + 1, sizeof *e.column);
    e.is_pivot = sga_calloc((size_t)cols + 1, 1);
    e.block = sga_calloc((size_t)cols + 1, sizeof *e.block);
    e.out = sga_calloc(1, sizeof *e.out);
    form_probe_init(&e.probe);
    eliminate(&e, 0, rows, -1, true);
    drop_zeros(&e, e.rank);
    find_blocks(&e);
    solve_blocks(&e);
    lift(&e);
    *count = e.count;
    form_probe_clear(&e.probe);
    free(e.column);
    free(e.is_pivot);
    free(e.block);
    return e.out;
}
