/* Sparse elimination in double with pivots by value and sparsity. */
#include "sparse.h"

#include <math.h>
#include <stdlib.h>

#include "mem.h"

static double entry(const struct points_row *r, int col)
{
    for (int k = 0; k < r->len; k++)
        if (r->col[k] == col)
            return r->val[k];
    return 0;
}

static double largest(const struct points_row *r)
{
    double m = 0;
    for (int k = 0; k < r->len; k++)
        m = fmax(m, fabs(r->val[k]));
    return m;
}

/* row i -= f * row p, with a dense work array that is zero on entry and exit */
static void subtract(struct points_row *i, const struct points_row *p, double f, int pivot_col, double *w, char *mark, int *count)
{
    for (int k = 0; k < i->len; k++) {
        w[i->col[k]] = i->val[k];
        mark[i->col[k]] = 1;
    }
    for (int k = 0; k < p->len; k++) {
        int c = p->col[k];
        if (!mark[c]) {
            if (i->len == i->cap) {
                i->cap = i->cap ? 2 * i->cap : 8;
                i->col = sga_realloc(i->col, (size_t)i->cap * sizeof *i->col);
                i->val = sga_realloc(i->val, (size_t)i->cap * sizeof *i->val);
            }
            i->col[i->len++] = c;
            mark[c] = 1;
            count[c]++;
        }
        w[c] -= f * p->val[k];
    }
    int n = 0;
    for (int k = 0; k < i->len; k++) {
        int c = i->col[k];
        mark[c] = 0;
        if (c != pivot_col) {
            i->col[n] = c;
            i->val[n++] = w[c];
        } else {
            count[c]--;
        }
        w[c] = 0;
    }
    i->len = n;
}

static bool choose(struct points_lu *lu, const char *done, const double *norm, double tiny, const int *count,
                   int *out_row, int *out_col)
{
    int best = -1;
    for (int i = 0; i < lu->rows; i++)
        if (!done[i] && largest(lu->row + i) > tiny * norm[i]
            && (best < 0 || lu->row[i].len < lu->row[best].len))
            best = i;
    if (best < 0)
        return false;
    const struct points_row *r = lu->row + best;
    double big = largest(r);
    int col = -1;
    for (int k = 0; k < r->len; k++) {
        double v = fabs(r->val[k]);
        if (v < 0.1 * big)
            continue;
        if (col < 0 || count[r->col[k]] < count[col] || (count[r->col[k]] == count[col] && v > fabs(entry(r, col))))
            col = r->col[k];
    }
    *out_row = best;
    *out_col = col;
    return true;
}

void points_lu_factor(struct points_lu *lu, struct points_row *row, int rows, int cols, double tiny)
{
    *lu = (struct points_lu){ .rows = rows, .cols = cols, .row = row };
    lu->pivot_row = sga_malloc((size_t)rows * sizeof(int));
    lu->pivot_col = sga_malloc((size_t)rows * sizeof(int));
    lu->pivot = sga_malloc((size_t)rows * sizeof(double));
    char *done = sga_calloc((size_t)rows, 1), *mark = sga_calloc((size_t)cols, 1);
    double *w = sga_calloc((size_t)cols, sizeof *w), *norm = sga_malloc((size_t)rows * sizeof *norm);
    int *count = sga_calloc((size_t)cols, sizeof *count);
    for (int i = 0; i < rows; i++) {
        norm[i] = largest(row + i);
        for (int k = 0; k < row[i].len; k++)
            count[row[i].col[k]]++;
    }
    int r, c;
    while (lu->rank < rows && choose(lu, done, norm, tiny, count, &r, &c)) {
        int step = lu->rank++;
        double p = entry(row + r, c);
        lu->pivot_row[step] = r;
        lu->pivot_col[step] = c;
        lu->pivot[step] = p;
        done[r] = 1;
        for (int i = 0; i < rows; i++) {
            double v = done[i] ? 0 : entry(row + i, c);
            if (v == 0)
                continue;
            SGA_RESERVE(lu->op, lu->op_cap, lu->ops + 1);
            lu->op[lu->ops].row = i;
            lu->op[lu->ops].step = step;
            lu->op[lu->ops++].factor = v / p;
            subtract(row + i, row + r, v / p, c, w, mark, count);
        }
    }
    free(done);
    free(mark);
    free(w);
    free(norm);
    free(count);
}

void points_lu_clear(struct points_lu *lu)
{
    for (int i = 0; i < lu->rows; i++) {
        free(lu->row[i].col);
        free(lu->row[i].val);
    }
    free(lu->row);
    free(lu->pivot_row);
    free(lu->pivot_col);
    free(lu->pivot);
    free(lu->op);
}

void points_lu_solve(const struct points_lu *lu, double *b, double *x)
{
    for (int k = 0; k < lu->ops; k++)
        b[lu->op[k].row] -= lu->op[k].factor * b[lu->pivot_row[lu->op[k].step]];
    for (int s = lu->rank - 1; s >= 0; s--) {
        const struct points_row *r = lu->row + lu->pivot_row[s];
        double v = b[lu->pivot_row[s]];
        for (int k = 0; k < r->len; k++)
            if (r->col[k] != lu->pivot_col[s])
                v -= r->val[k] * x[r->col[k]];
        x[lu->pivot_col[s]] = v / lu->pivot[s];
    }
}
