/* See the header. */
#include "expr.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "expr_rows.h"
#include "mem.h"

struct expr_rows expr_rows_new(int rows, int entries)
{
    return (struct expr_rows){ sga_calloc((size_t)rows + 1, sizeof(int)), sga_malloc(((size_t)entries + 1) * sizeof(int)),
                               sga_malloc(((size_t)entries + 1) * sizeof(expr_id)) };
}

struct expr_rows expr_rows_of(int rows, int cols, const expr_id *dense, expr_id zero)
{
    size_t size = (size_t)rows * (size_t)cols;
    int entries = 0;
    for (size_t k = 0; k < size; k++)
        entries += dense[k] != zero;
    struct expr_rows a = expr_rows_new(rows, entries);
    entries = 0;
    for (int i = 0; i < rows; i++) {
        for (int j = 0; j < cols; j++) {
            expr_id e = dense[(size_t)i * (size_t)cols + (size_t)j];
            if (e == zero)
                continue;
            a.column[entries] = j;
            a.entry[entries++] = e;
        }
        a.start[i + 1] = entries;
    }
    return a;
}

struct expr_rows expr_rows_copy(const struct expr_rows *a, int rows, expr_id zero)
{
    struct expr_rows r = expr_rows_new(rows, a->start[rows]);
    int count = 0;
    for (int i = 0; i < rows; i++) {
        for (int k = a->start[i]; k < a->start[i + 1]; k++) {
            assert(k == a->start[i] || a->column[k] > a->column[k - 1]);
            r.column[count] = a->column[k];
            r.entry[count] = a->entry[k];
            count += a->entry[k] != zero;
        }
        r.start[i + 1] = count;
    }
    return r;
}

struct expr_rows expr_rows_transposed(const struct expr_rows *a, int rows, int cols)
{
    int entries = a->start[rows];
    struct expr_rows t = expr_rows_new(cols, entries);
    for (int k = 0; k < entries; k++) {
        assert(a->column[k] >= 0 && a->column[k] < cols);
        t.start[a->column[k] + 1]++;
    }
    for (int j = 0; j < cols; j++)
        t.start[j + 1] += t.start[j];
    SGA_FREED int *next = sga_malloc(((size_t)cols + 1) * sizeof *next);
    memcpy(next, t.start, (size_t)cols * sizeof *next);
    for (int i = 0; i < rows; i++)
        for (int k = a->start[i]; k < a->start[i + 1]; k++) {
            int place = next[a->column[k]]++;
            t.column[place] = i;
            t.entry[place] = a->entry[k];
        }
    return t;
}

void expr_rows_sort(struct expr_rows *a, int rows, int cols)
{
    struct expr_rows t = expr_rows_transposed(a, rows, cols);
    expr_rows_clear(a);
    *a = expr_rows_transposed(&t, cols, rows);
    expr_rows_clear(&t);
}

bool expr_rows_same(const struct expr_rows *a, const struct expr_rows *b, int rows)
{
    size_t entries = (size_t)a->start[rows];
    return !memcmp(a->start, b->start, ((size_t)rows + 1) * sizeof(int)) && !memcmp(a->column, b->column, entries * sizeof(int))
           && !memcmp(a->entry, b->entry, entries * sizeof(expr_id));
}

expr_id expr_rows_at(const struct expr_rows *a, int row, int col)
{
    int low = a->start[row], high = a->start[row + 1];
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (a->column[middle] == col)
            return a->entry[middle];
        if (a->column[middle] < col)
            low = middle + 1;
        else
            high = middle;
    }
    return EXPR_UNDEF;
}

void expr_rows_clear(struct expr_rows *a)
{
    free(a->start);
    free(a->column);
    free(a->entry);
    *a = (struct expr_rows){ 0 };
}
