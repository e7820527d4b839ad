/* Sparse matrices in compressed rows. */
#include "lin_sparse.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"

static struct lin_sparse *allocate(int rows, int cols, int count)
{
    struct lin_sparse *a = sga_malloc(sizeof *a);
    a->rows = rows;
    a->cols = cols;
    a->ptr = sga_calloc((size_t)rows + 1, sizeof *a->ptr);
    a->col = sga_calloc((size_t)count + 1, sizeof *a->col);
    a->val = sga_calloc((size_t)count + 1, sizeof *a->val);
    return a;
}

static void assert_sound(const struct lin_sparse *a)
{
    SGA_FREED int *seen = sga_calloc((size_t)a->cols + 1, sizeof *seen);
    for (int i = 0; i < a->rows; i++) {
        assert(a->ptr[i] <= a->ptr[i + 1]);
        for (int k = a->ptr[i]; k < a->ptr[i + 1]; k++) {
            assert(a->col[k] >= 0 && a->col[k] < a->cols);
            assert(seen[a->col[k]] != i + 1);
            seen[a->col[k]] = i + 1;
        }
    }
}

struct lin_sparse *lin_sparse_new(int rows, int cols, const int *ptr, const int *col)
{
    assert(rows >= 0 && cols >= 0 && (rows == 0 || ptr[0] == 0));
    int count = rows ? ptr[rows] : 0;
    struct lin_sparse *a = allocate(rows, cols, count);
    if (rows)
        memcpy(a->ptr, ptr, ((size_t)rows + 1) * sizeof *ptr);
    if (count)
        memcpy(a->col, col, (size_t)count * sizeof *col);
    assert_sound(a);
    return a;
}

void lin_sparse_free(struct lin_sparse *a)
{
    if (!a)
        return;
    free(a->ptr);
    free(a->col);
    free(a->val);
    free(a);
}

/* order[]: the positions sorted by row (stable counting sort), start[]: where rows begin. */
static void sort_by_row(int rows, int count, const int *row, int *start, int *order)
{
    for (int k = 0; k < count; k++)
        start[row[k] + 1]++;
    for (int i = 0; i < rows; i++)
        start[i + 1] += start[i];
    SGA_FREED int *next = sga_malloc(((size_t)rows + 1) * sizeof *next);
    memcpy(next, start, ((size_t)rows + 1) * sizeof *next);
    for (int k = 0; k < count; k++)
        order[next[row[k]]++] = k;
}

struct lin_sparse *lin_sparse_from_entries(int rows, int cols, int count,
                                           const int *row, const int *column, int *place)
{
    for (int k = 0; k < count; k++)
        assert(row[k] >= 0 && row[k] < rows && column[k] >= 0 && column[k] < cols);
    struct lin_sparse *a = allocate(rows, cols, count);
    SGA_ARENA(mem);
    int *start = sga_zeros(&mem, (size_t)rows + 1, sizeof *start);
    int *order = sga_take(&mem, ((size_t)count + 1) * sizeof *order);
    int *where = sga_take(&mem, ((size_t)cols + 1) * sizeof *where);  /* entry of this row */
    sort_by_row(rows, count, row, start, order);
    for (int j = 0; j < cols; j++)
        where[j] = -1;
    int used = 0;
    for (int i = 0; i < rows; i++) {
        a->ptr[i] = used;
        for (int k = start[i]; k < start[i + 1]; k++) {
            int j = column[order[k]];
            if (where[j] < a->ptr[i]) {
                a->col[used] = j;
                where[j] = used++;
            }
            if (place)
                place[order[k]] = where[j];
        }
    }
    a->ptr[rows] = used;
    return a;
}

void lin_sparse_times(const struct lin_sparse *a, const double *x, double *y)
{
    for (int i = 0; i < a->rows; i++) {
        double s = 0;
        for (int k = a->ptr[i]; k < a->ptr[i + 1]; k++)
            s += a->val[k] * x[a->col[k]];
        y[i] = s;
    }
}

void lin_sparse_transpose_times(const struct lin_sparse *a, const double *x, double *y)
{
    for (int j = 0; j < a->cols; j++)
        y[j] = 0;
    for (int i = 0; i < a->rows; i++)
        for (int k = a->ptr[i]; k < a->ptr[i + 1]; k++)
            y[a->col[k]] += a->val[k] * x[i];
}

int lin_all_finite(int n, const double *v)
{
    double s = 0;
    for (int i = 0; i < n; i++)
        s += v[i] * 0.0;   /* NaN as soon as one is not finite */
    return s == 0;
}
