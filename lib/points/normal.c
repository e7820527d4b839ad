/* Least-norm steps: dense for small systems, sparse for larger ones. */
#include "normal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "leastnorm.h"
#include "lin_kkt.h"
#include "lin_normal.h"
#include "lin_sparse.h"
#include "mem.h"
#include "sparse.h"

enum { DENSE_ROWS = 24, MANY = 500 };
/* Multiplications of one dense step, some milliseconds, which a search may take hundreds of times; past them the step is a sparse one, of no least norm. */
static const double DENSE_WORK = 2e7;
/* Of a row's length, once the rows before it are taken out, for steps that are looked at again: a tenth of a thousandth of a step may be wrong. */
static const double LEAST_LEFT = 1e-6;

static struct lin_sparse *pattern(const struct normal *w)
{
    SGA_ARENA(mem);
    int *ptr = sga_zeros(&mem, (size_t)w->c + 1, sizeof *ptr);
    for (int i = 0; i < w->c; i++)
        ptr[i + 1] = ptr[i] + w->cols[i];
    int *all = sga_take(&mem, (size_t)(ptr[w->c] + 1) * sizeof *all);
    for (int i = 0; i < w->c; i++)
        memcpy(all + ptr[i], w->col[i], (size_t)w->cols[i] * sizeof *all);
    struct lin_sparse *J = lin_sparse_new(w->c, w->n, ptr, all);
    return J;
}

void normal_init(struct normal *w, int c, int n, int *const *col, const int *cols)
{
    size_t entries = 0, at = 0;
    *w = (struct normal){ .c = c, .n = n, .col = col, .cols = cols };
    for (int i = 0; i < c; i++)
        entries += (size_t)cols[i];
    w->packed = sga_zeros(&w->mem, entries + 1, sizeof *w->packed);
    w->value = sga_zeros(&w->mem, (size_t)c + 1, sizeof *w->value);
    for (int i = 0; i < c; i++) {
        w->value[i] = w->packed + at;
        at += (size_t)cols[i];
    }
}

bool normal_is_sparse(const struct normal *w)
{
    return w->c > DENSE_ROWS;
}

static struct lin_kkt *kkt(struct normal *w)
{
    if (!w->kkt) {
        struct lin_sparse *J = pattern(w);
        w->kkt = lin_kkt_new(J);
        lin_sparse_free(J);
    }
    return w->kkt;
}

void normal_clear(struct normal *w)
{
    sga_arena_end(&w->mem);
    lin_kkt_free(w->kkt);
    lin_normal_free(w->quick);
}

static int dense(struct normal *w, const double *r, double *d)
{
    size_t c = (size_t)w->c, n = (size_t)w->n;
    if (!w->dense) {
        w->dense = sga_take(&w->mem, (c * n + 1) * sizeof *w->dense);
        w->work = sga_take(&w->mem, (c + c * c + 1) * sizeof *w->work);
        w->perm = sga_take(&w->mem, (c + 1) * sizeof *w->perm);
    }
    memset(w->dense, 0, c * n * sizeof *w->dense);
    for (size_t i = 0; i < c; i++)
        for (int k = 0; k < w->cols[i]; k++)
            w->dense[i * n + (size_t)w->col[i][k]] = w->value[i][k];
    return points_least_norm(w->c, w->n, w->dense, r, d, w->perm, w->work);
}

int normal_step(struct normal *w, const double *r, double *d)
{
    if (!normal_is_sparse(w))
        return dense(w, r, d);
    if (lin_kkt_fills(kkt(w)))
        return normal_basic_step(w, r, d);
    if (!lin_kkt_factor(w->kkt, w->packed, NULL, NULL))
        return (double)w->c * w->c * w->n > DENSE_WORK ? normal_basic_step(w, r, d) : dense(w, r, d);
    lin_kkt_solve(w->kkt, r, NULL, d);
    return w->c;
}

int normal_quick_step(struct normal *w, const double *r, double *d)
{
    if (!w->quick_tried) {
        struct lin_sparse *J = pattern(w);
        w->quick = lin_normal_new(J);
        w->quick_tried = true;
        lin_sparse_free(J);
    }
    return w->quick && lin_normal_step(w->quick, w->packed, r, d) ? w->c : normal_step(w, r, d);
}

/* The same where all rows that have entries are independent, all columns of them moving: their number; 0 where they are not, or it would cost more. */
static int entries_step(struct normal *w, const double *r, double *d)
{
    SGA_ARENA(mem);
    int rows = 0, entries = 0, columns = 0, count = 0;
    for (int i = 0; i < w->c; i++)
        entries += w->cols[i];
    int *ptr = sga_zeros(&mem, (size_t)w->c + 1, sizeof *ptr), *col = sga_take(&mem, ((size_t)entries + 1) * sizeof *col);
    int *place = sga_take(&mem, ((size_t)w->n + 1) * sizeof *place), *column = sga_take(&mem, ((size_t)w->n + 1) * sizeof *column);
    double *val = sga_take(&mem, ((size_t)entries + 1) * sizeof *val), *b = sga_take(&mem, ((size_t)w->c + 1) * sizeof *b);
    memset(place, -1, ((size_t)w->n + 1) * sizeof *place);
    for (int i = 0; i < w->c; i++) {
        for (int k = 0; k < w->cols[i]; k++) {
            int j = w->col[i][k];
            if (w->value[i][k] == 0)
                continue;
            if (place[j] < 0) {
                column[columns] = j;
                place[j] = columns++;
            }
            col[count] = place[j];
            val[count++] = w->value[i][k];
        }
        if (count > ptr[rows]) {
            b[rows++] = r[i];
            ptr[rows] = count;
        }
    }
    if (rows > columns || !rows)
        return 0;
    struct lin_sparse *J = lin_sparse_new(rows, columns, ptr, col);
    struct lin_normal *s = lin_normal_new(J);
    double *by = sga_take(&mem, ((size_t)columns + 1) * sizeof *by);
    bool ok = s && lin_normal_factor(s, val, LEAST_LEFT) && lin_normal_solve(s, val, b, by);
    memset(d, 0, (size_t)w->n * sizeof *d);
    for (int k = 0; k < columns && ok; k++)
        d[column[k]] = by[k];
    lin_normal_free(s);
    lin_sparse_free(J);
    return ok ? rows : 0;
}

int normal_basic_step(struct normal *w, const double *r, double *d)
{
    int all = w->c > MANY ? entries_step(w, r, d) : 0;
    if (all)
        return all;
    struct points_row *row = sga_calloc((size_t)w->c + 1, sizeof *row);
    SGA_FREED double *b = sga_malloc((size_t)(w->c + 1) * sizeof *b);
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
    SGA_ENDS(points_lu_clear) struct points_lu lu;
    points_lu_factor(&lu, row, w->c, w->n, 1e-10);
    memset(d, 0, (size_t)w->n * sizeof *d);
    points_lu_solve(&lu, b, d);
    assert(lu.rank <= w->c);
    return lu.rank;
}
