/* Rows that are left are combined as the operations say, in all columns. */
#include "sparse_complete.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "arena.h"
#include "sparse.h"

/* What is left of a row beside its largest entry: from there on it is no rounding. */
static const double LEFT_SURE = 1e-8;

/* What the operations make of row i: x (cols). of: work (rows). */
static void remainder_of(const struct points_lu *lu, const struct points_row *row, int i, double *x, double *of)
{
    memset(of, 0, (size_t)lu->rows * sizeof *of);
    memset(x, 0, (size_t)lu->cols * sizeof *x);
    of[i] = 1;
    for (int k = lu->ops - 1; k >= 0; k--)
        of[lu->pivot_row[lu->op[k].step]] -= lu->op[k].factor * of[lu->op[k].row];
    for (int j = 0; j < lu->rows; j++)
        for (int k = 0; k < row[j].len && of[j] != 0; k++)
            x[row[j].col[k]] += of[j] * row[j].val[k];
    for (int s = 0; s < lu->rank; s++)
        x[lu->pivot_col[s]] = 0;
}

/* Pivots for the rows at[0 .. left) with the remainders x (left x cols), the largest first. False: one is neither large nor nothing. */
static bool more_pivots(struct points_lu *lu, const double *norm, int *at, int left, double *x, double tiny)
{
    size_t n = (size_t)lu->cols;
    while (left > 0) {
        int best = 0, column = 0;
        double size = -1;
        for (int a = 0; a < left; a++)
            for (int j = 0; j < lu->cols; j++)
                if (fabs(x[(size_t)a * n + (size_t)j]) > size * norm[at[a]]) {
                    size = fabs(x[(size_t)a * n + (size_t)j]) / norm[at[a]];
                    best = a;
                    column = j;
                }
        if (!(size > tiny))
            return true;
        if (size < LEFT_SURE)
            return false;
        lu->pivot_row[lu->rank] = at[best];
        lu->pivot_col[lu->rank++] = column;
        left--;
        at[best] = at[left];
        double *p = x + (size_t)best * n, *last = x + (size_t)left * n;
        for (size_t j = 0; j < n; j++) {
            double v = p[j];
            p[j] = last[j];
            last[j] = v;
        }
        for (int a = 0; a < left; a++) {
            double *r = x + (size_t)a * n, f = r[column] / last[column];
            for (size_t j = 0; j < n && f != 0; j++)
                r[j] -= f * last[j];
            r[column] = 0;
        }
    }
    return true;
}

bool points_complete(struct points_lu *lu, const struct points_row *row, const double *norm, double tiny)
{
    SGA_ARENA(mem);
    int left = 0;
    unsigned char *has = sga_zeros(&mem, (size_t)lu->rows + 1, 1);
    for (int s = 0; s < lu->rank; s++)
        has[lu->pivot_row[s]] = 1;
    if (lu->rows - lu->rank > POINTS_MOST_LEFT)
        return false;
    int at[POINTS_MOST_LEFT];
    for (int i = 0; i < lu->rows; i++)
        if (!has[i])
            at[left++] = i;
    double *x = sga_take(&mem, ((size_t)left * (size_t)lu->cols + 1) * sizeof *x), *of = sga_take(&mem, ((size_t)lu->rows + 1) * sizeof *of);
    for (int a = 0; a < left; a++)
        remainder_of(lu, row, at[a], x + (size_t)a * (size_t)lu->cols, of);
    assert(lu->rank + left <= lu->rows);
    return more_pivots(lu, norm, at, left, x, tiny);
}
