/* Least-norm steps, dense or by the sparse normal equations. */
#include "normal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "leastnorm.h"
#include "mem.h"
#include "sparse.h"

enum { DENSE_ROWS = 24 };

void normal_init(struct normal *w, int c, int n, int *const *col, const int *cols)
{
    *w = (struct normal){ .c = c, .n = n, .col = col, .cols = cols };
    w->value = sga_calloc((size_t)c, sizeof *w->value);
    for (int i = 0; i < c; i++)
        w->value[i] = sga_calloc((size_t)cols[i], sizeof **w->value);
}

void normal_clear(struct normal *w)
{
    for (int i = 0; i < w->c; i++)
        free(w->value[i]);
    free(w->value);
}

static int dense(struct normal *w, const double *r, double *d)
{
    double *J = sga_calloc((size_t)w->c * (size_t)w->n, sizeof *J);
    for (int i = 0; i < w->c; i++)
        for (int k = 0; k < w->cols[i]; k++)
            J[(size_t)i * (size_t)w->n + (size_t)w->col[i][k]] = w->value[i][k];
    int rank = points_least_norm(w->c, w->n, J, r, d);
    free(J);
    return rank;
}

/* Rows of J J^T: row i meets every row that shares a column with it. */
static struct points_row *normal_matrix(struct normal *w)
{
    int c = w->c, *count = sga_calloc((size_t)w->n + 1, sizeof *count);
    for (int i = 0; i < c; i++)
        for (int k = 0; k < w->cols[i]; k++)
            count[w->col[i][k] + 1]++;
    for (int j = 0; j < w->n; j++)
        count[j + 1] += count[j];
    int *row = sga_malloc((size_t)(count[w->n] + 1) * sizeof *row), *next = sga_malloc((size_t)(w->n + 1) * sizeof *next);
    double *val = sga_malloc((size_t)(count[w->n] + 1) * sizeof *val);
    memcpy(next, count, (size_t)(w->n + 1) * sizeof *next);
    for (int i = 0; i < c; i++)
        for (int k = 0; k < w->cols[i]; k++) {
            int at = next[w->col[i][k]]++;
            row[at] = i;
            val[at] = w->value[i][k];
        }
    struct points_row *m = sga_calloc((size_t)c, sizeof *m);
    double *sum = sga_calloc((size_t)c, sizeof *sum);
    int *place = sga_malloc((size_t)c * sizeof *place);
    for (int i = 0; i < c; i++)
        place[i] = -1;
    for (int i = 0; i < c; i++) {
        for (int k = 0; k < w->cols[i]; k++) {
            int j = w->col[i][k];
            for (int q = count[j]; q < count[j + 1]; q++) {
                int o = row[q];
                if (place[o] < 0) {
                    if (m[i].len == m[i].cap) {
                        m[i].cap = m[i].cap ? 2 * m[i].cap : 8;
                        m[i].col = sga_realloc(m[i].col, (size_t)m[i].cap * sizeof *m[i].col);
                        m[i].val = sga_realloc(m[i].val, (size_t)m[i].cap * sizeof *m[i].val);
                    }
                    place[o] = m[i].len;
                    m[i].col[m[i].len++] = o;
                }
                sum[o] += w->value[i][k] * val[q];
            }
        }
        for (int k = 0; k < m[i].len; k++) {
            m[i].val[k] = sum[m[i].col[k]];
            sum[m[i].col[k]] = 0;
            place[m[i].col[k]] = -1;
        }
    }
    free(count);
    free(row);
    free(next);
    free(val);
    free(sum);
    free(place);
    return m;
}

int normal_step(struct normal *w, const double *r, double *d)
{
    int c = w->c;
    if (c <= DENSE_ROWS)
        return dense(w, r, d);
    struct points_lu lu;
    points_lu_factor(&lu, normal_matrix(w), c, c, 1e-12);
    bool ok = lu.rank == c;
    if (ok) {
        double *b = sga_malloc((size_t)c * sizeof *b), *y = sga_calloc((size_t)c, sizeof *y);
        for (int i = 0; i < c; i++)
            b[i] = -r[i];
        points_lu_solve(&lu, b, y);
        memset(d, 0, (size_t)w->n * sizeof *d);
        for (int i = 0; i < c; i++)
            for (int k = 0; k < w->cols[i]; k++)
                d[w->col[i][k]] += w->value[i][k] * y[i];
        for (int j = 0; j < w->n; j++)
            ok &= isfinite(d[j]) != 0;
        free(b);
        free(y);
    }
    points_lu_clear(&lu);
    return ok ? c : dense(w, r, d);
}
