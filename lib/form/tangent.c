/* The kernel of a matrix of expressions, with pivots chosen by structure.
 *
 * Every row ends as  d x_p + sum r_f x_f = 0  with its pivot d; the vector of the free
 * column f is then e_f times the pivots of the rows that have an r_f, so that nothing is
 * divided and the vectors are defined wherever the matrix is. */
#include "tangent.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "probe.h"

struct elimination {
    struct expr_store *st;
    expr_id *a;
    int rows, cols, rank;
    int *column;               /* of the pivot of row i < rank */
    unsigned char *is_pivot;   /* by column */
    struct form_probe probe;
};

/* The best pivot in rows that have none: a constant, or else what is not 0 at a point. */
static bool choose(struct elimination *e, int *row, int *col)
{
    bool found = false;
    for (int i = e->rank; i < e->rows; i++)
        for (int j = 0; j < e->cols; j++) {
            expr_id v = e->a[(size_t)i * (size_t)e->cols + (size_t)j];
            if (expr_is_zero(e->st, v) || (found && !expr_is_const(e->st, v)))
                continue;
            if (!expr_is_const(e->st, v) && form_probe_zero(&e->probe, e->st, v))
                continue;
            *row = i;
            *col = j;
            found = true;
            if (expr_is_const(e->st, v))
                return true;
        }
    return found;
}

static void swap_rows(struct elimination *e, int i, int k)
{
    for (int j = 0; j < e->cols && i != k; j++) {
        expr_id *x = e->a + (size_t)i * (size_t)e->cols + j, *y = e->a + (size_t)k * (size_t)e->cols + j;
        expr_id t = *x;
        *x = *y;
        *y = t;
    }
}

/* row_i := pivot * row_i - a_ip * row_k; a constant pivot has been made 1. */
static void clear_column(struct elimination *e, int i, int k, int p)
{
    struct expr_store *st = e->st;
    expr_id *x = e->a + (size_t)i * (size_t)e->cols, *y = e->a + (size_t)k * (size_t)e->cols;
    expr_id factor = x[p], pivot = y[p];
    if (i == k || expr_is_zero(st, factor))
        return;
    for (int j = 0; j < e->cols; j++)
        x[j] = j == p ? expr_int(st, 0)
                      : expr_sub(st, expr_mul(st, pivot, x[j]), expr_mul(st, factor, y[j]));
}

static void eliminate(struct elimination *e)
{
    int row = 0, col = 0;
    while (e->rank < e->rows && choose(e, &row, &col)) {
        int k = e->rank++;
        swap_rows(e, row, k);
        expr_id *y = e->a + (size_t)k * (size_t)e->cols, pivot = y[col];
        for (int j = 0; j < e->cols && expr_is_const(e->st, pivot); j++)
            y[j] = expr_div(e->st, y[j], pivot);
        e->column[k] = col;
        e->is_pivot[col] = 1;
        for (int i = 0; i < e->rows; i++)
            clear_column(e, i, k, col);
    }
}

static void tangent_vector(const struct elimination *e, int f, expr_id *v)
{
    struct expr_store *st = e->st;
    for (int j = 0; j < e->cols; j++)
        v[j] = expr_int(st, j == f);
    for (int i = 0; i < e->rank; i++) {
        const expr_id *row = e->a + (size_t)i * (size_t)e->cols;
        if (expr_is_zero(st, row[f]))
            continue;
        expr_id scale = v[f], pivot = row[e->column[i]];
        for (int j = 0; j < e->cols; j++)
            v[j] = expr_mul(st, pivot, v[j]);
        v[e->column[i]] = expr_neg(st, expr_mul(st, scale, row[f]));
    }
}

expr_id *form_kernel(struct expr_store *st, expr_id *matrix, int rows, int cols, int *count)
{
    struct elimination e = { .st = st, .a = matrix, .rows = rows, .cols = cols };
    e.column = sga_calloc((size_t)rows + 1, sizeof *e.column);
    e.is_pivot = sga_calloc((size_t)cols + 1, 1);
    form_probe_init(&e.probe);
    eliminate(&e);
    *count = cols - e.rank;
    expr_id *kernel = sga_calloc((size_t)*count * (size_t)cols + 1, sizeof *kernel);
    for (int f = 0, k = 0; f < cols; f++)
        if (!e.is_pivot[f])
            tangent_vector(&e, f, kernel + (size_t)k++ * (size_t)cols);
    form_probe_clear(&e.probe);
    free(e.column);
    free(e.is_pivot);
    return kernel;
}
