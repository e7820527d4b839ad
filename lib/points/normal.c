/* Least-norm steps: dense for small systems, sparse for larger ones. */
#include "normal.h"

#include <stdlib.h>
#include <string.h>

#include "leastnorm.h"
#include "lin_kkt.h"
#include "mem.h"
#include "sparse.h"

enum { DENSE_ROWS = 24 };

void normal_init(struct normal *w, int c, int n, int *const *col, const int *cols)
{
    *w = (struct normal){ .c = c, .n = n, .col = col, .cols = cols };
    w->value = sga_calloc((size_t)c, sizeof *w->value);
    int *ptr = sga_calloc((size_t)c + 1, sizeof *ptr);
    for (int i = 0; i < c; i++) {
        w->value[i] = sga_calloc((size_t)cols[i], sizeof **w->value);
        ptr[i + 1] = ptr[i] + cols[i];
    }
    if (c > DENSE_ROWS) {
        int *all = sga_malloc((size_t)(ptr[c] + 1) * sizeof *all);
        for (int i = 0; i < c; i++)
            memcpy(all + ptr[i], col[i], (size_t)cols[i] * sizeof *all);
        struct lin_sparse *J = lin_sparse_new(c, n, ptr, all);
        w->kkt = lin_kkt_new(J);
        w->packed = sga_malloc((size_t)(ptr[c] + 1) * sizeof *w->packed);
        lin_sparse_free(J);
        free(all);
    }
    free(ptr);
}

void normal_clear(struct normal *w)
{
    for (int i = 0; i < w->c; i++)
        free(w->value[i]);
    free(w->value);
    lin_kkt_free(w->kkt);
    free(w->packed);
    free(w->dense);
    free(w->work);
    free(w->perm);
}

static int dense(struct normal *w, const double *r, double *d)
{
    size_t c = (size_t)w->c, n = (size_t)w->n;
    if (!w->dense) {
        w->dense = sga_malloc((c * n + 1) * sizeof *w->dense);
        w->work = sga_malloc((c + c * c + 1) * sizeof *w->work);
        w->perm = sga_malloc((c + 1) * sizeof *w->perm);
    }
    memset(w->dense, 0, c * n * sizeof *w->dense);
    for (size_t i = 0; i < c; i++)
        for (int k = 0; k < w->cols[i]; k++)
            w->dense[i * n + (size_t)w->col[i][k]] = w->value[i][k];
    return points_least_norm_in(w->c, w->n, w->dense, r, d, w->perm, w->work);
}

int normal_step(struct normal *w, const double *r, double *d)
{
    if (!w->kkt)
        return dense(w, r, d);
    int at = 0;
    for (int i = 0; i < w->c; i++) {
        memcpy(w->packed + at, w->value[i], (size_t)w->cols[i] * sizeof *w->packed);
        at += w->cols[i];
    }
    if (!lin_kkt_factor(w->kkt, w->packed, NULL, NULL))
        return dense(w, r, d);
    lin_kkt_solve(w->kkt, r, NULL, d);
    return w->c;
}

int normal_basic_step(struct normal *w, const double *r, double *d)
{
    struct points_row *row = sga_calloc((size_t)w->c + 1, sizeof *row);
    double *b = sga_malloc((size_t)(w->c + 1) * sizeof *b);
    for (int i = 0; i < w->c; i++) {
        row[i].cap = w->cols[i];
        row[i].col = sga_malloc((size_t)(w->cols[i] + 1) * sizeof(int));
        row[i].val = sga_malloc((size_t)(w->cols[i] + 1) * sizeof(double));
        for (int k = 0; k < w->cols[i]; k++) {
            if (w->value[i][k] == 0)
                continue;
            row[i].col[row[i].len] = w->col[i][k];
            row[i].val[row[i].len++] = w->value[i][k];
        }
        b[i] = -r[i];
    }
    struct points_lu lu;
    points_lu_factor(&lu, row, w->c, w->n, 1e-10);
    memset(d, 0, (size_t)w->n * sizeof *d);
    points_lu_solve(&lu, b, d);
    int rank = lu.rank;
    points_lu_clear(&lu);
    free(b);
    return rank;
}
