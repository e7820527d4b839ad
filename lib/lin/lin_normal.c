/* Sparse L D L^T of J J^T; see the header. */
#include "lin_normal.h"

#include <stdlib.h>
#include <string.h>
#include <suitesparse/amd.h>

#include "arena.h"
#include "lin_sparse.h"
#include "mem.h"

/* What is left of a row's squared length once the rows before it are taken out. */
static const double LEAST_PIVOT = 1e-6;
/* Products, and entries of L, for each entry of J (and some for nothing). */
enum { MOST_PRODUCTS = 48, MOST_FILL = 16, FREE = 2000 };

/* One term of an entry of J J^T: row k of it is being summed up, the column is j. */
struct product { int j, a, b; };

struct lin_normal {
    struct sga_arena mem;
    int c, n;
    struct lin_sparse *J;          /* the pattern */
    int *order;                    /* row k of L is row order[k] of J */
    int *from;                     /* c + 1: the products of row k are from[k] .. */
    struct product *product;
    int *column, *row;             /* L below its diagonal, by columns */
    int *left, *at, *place;        /* the same by rows: columns, and where each stands in `row` */
    double *L, *D, *y;             /* y: 0 between rows */
};

/* By columns of J: its rows, and the places of the entries. */
struct transpose { int *ptr, *row, *place; };

static struct transpose transpose(const struct lin_sparse *J)
{
    int nz = J->ptr[J->rows];
    struct transpose t = { sga_calloc((size_t)J->cols + 2, sizeof(int)), sga_malloc(((size_t)nz + 1) * sizeof(int)),
                           sga_malloc(((size_t)nz + 1) * sizeof(int)) };
    for (int e = 0; e < nz; e++)
        t.ptr[J->col[e] + 2]++;
    for (int j = 0; j < J->cols; j++)
        t.ptr[j + 1] += t.ptr[j];
    for (int i = 0; i < J->rows; i++)
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++) {
            int at = t.ptr[J->col[e] + 1]++;
            t.row[at] = i;
            t.place[at] = e;
        }
    return t;
}

static void transpose_clear(struct transpose *t)
{
    free(t->ptr);
    free(t->row);
    free(t->place);
}

static bool too_many_products(const struct lin_sparse *J, const struct transpose *t)
{
    double sum = 0;
    for (int j = 0; j < J->cols; j++)
        sum += (double)(t->ptr[j + 1] - t->ptr[j]) * (t->ptr[j + 1] - t->ptr[j]);
    return sum > (double)MOST_PRODUCTS * J->ptr[J->rows] + FREE;
}

/* Neighbours: rows that share a column. AMD's order. */
static bool find_order(struct lin_normal *s, const struct transpose *t)
{
    const struct lin_sparse *J = s->J;
    SGA_ARENA(mem);
    int *ptr = sga_zeros(&mem, (size_t)s->c + 1, sizeof *ptr), *to = NULL, *seen = sga_take(&mem, ((size_t)s->c + 1) * sizeof *seen);
    int count = 0;
    size_t cap = 0;
    memset(seen, -1, ((size_t)s->c + 1) * sizeof *seen);
    for (int i = 0; i < s->c; i++) {
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++)
            for (int q = t->ptr[J->col[e]]; q < t->ptr[J->col[e] + 1]; q++) {
                if (seen[t->row[q]] == i)
                    continue;
                seen[t->row[q]] = i;
                SGA_RESERVE(to, cap, count + 1);
                to[count++] = t->row[q];
            }
        ptr[i + 1] = count;
    }
    bool ok = count > 0 && amd_order(s->c, ptr, to, s->order, NULL, NULL) >= AMD_OK;
    free(to);
    return ok;
}

/* The products that make up each row of J J^T up to its diagonal, in the new order. */
static void list_products(struct lin_normal *s, const struct transpose *t)
{
    const struct lin_sparse *J = s->J;
    SGA_FREED int *rank = sga_malloc(((size_t)s->c + 1) * sizeof *rank);
    int count = 0;
    size_t cap = 0;
    for (int k = 0; k < s->c; k++)
        rank[s->order[k]] = k;
    for (int k = 0; k < s->c; k++) {
        int i = s->order[k];
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++)
            for (int q = t->ptr[J->col[e]]; q < t->ptr[J->col[e] + 1]; q++) {
                if (rank[t->row[q]] > k)
                    continue;
                SGA_RESERVE(s->product, cap, count + 1);
                s->product[count++] = (struct product){ rank[t->row[q]], e, t->place[q] };
            }
        s->from[k + 1] = count;
    }
}

/* The columns of row k of L: from each column of J J^T up the elimination tree. Calls with `row`
 * NULL count. */
static void find_rows(struct lin_normal *s, int *parent, int *seen, int *fill, int *row)
{
    for (int k = 0; k < s->c; k++) {
        parent[k] = -1;
        seen[k] = k;
        for (int p = s->from[k]; p < s->from[k + 1]; p++)
            for (int i = s->product[p].j; seen[i] != k; i = parent[i]) {
                if (parent[i] < 0)
                    parent[i] = k;
                if (row)
                    row[s->column[i] + fill[i]] = k;
                fill[i]++;
                seen[i] = k;
            }
    }
}

static bool find_pattern(struct lin_normal *s)
{
    size_t c = (size_t)s->c + 1;
    SGA_ARENA(mem);
    int *parent = sga_take(&mem, c * sizeof *parent), *seen = sga_take(&mem, c * sizeof *seen), *fill = sga_zeros(&mem, c, sizeof *fill);
    memset(seen, -1, c * sizeof *seen);
    find_rows(s, parent, seen, fill, NULL);
    double all = 0;
    for (int i = 0; i < s->c; i++)
        all += fill[i];
    bool ok = all <= (double)MOST_FILL * s->J->ptr[s->c] + FREE;
    if (ok) {
        size_t nz = (size_t)all + 1;
        for (int i = 0; i < s->c; i++)
            s->column[i + 1] = s->column[i] + fill[i];
        s->row = sga_take(&s->mem, nz * sizeof *s->row);
        s->at = sga_take(&s->mem, nz * sizeof *s->at);
        s->place = sga_take(&s->mem, nz * sizeof *s->place);
        s->L = sga_zeros(&s->mem, nz, sizeof *s->L);
        memset(seen, -1, c * sizeof *seen);
        memset(fill, 0, c * sizeof *fill);
        find_rows(s, parent, seen, fill, s->row);
        for (int i = 0; i < s->c; i++)
            for (int q = s->column[i]; q < s->column[i + 1]; q++)
                s->left[s->row[q] + 1]++;
        for (int k = 0; k < s->c; k++)
            s->left[k + 1] += s->left[k];
        memcpy(fill, s->left, (c - 1) * sizeof *fill);
        for (int i = 0; i < s->c; i++)
            for (int q = s->column[i]; q < s->column[i + 1]; q++) {
                int to = fill[s->row[q]]++;
                s->at[to] = i;
                s->place[to] = q;
            }
    }
    return ok;
}

struct lin_normal *lin_normal_new(const struct lin_sparse *J)
{
    struct lin_normal *s = sga_calloc(1, sizeof *s);
    size_t c = (size_t)J->rows + 1;
    SGA_ENDS(transpose_clear) struct transpose t = transpose(J);
    s->c = J->rows;
    s->n = J->cols;
    s->J = lin_sparse_new(J->rows, J->cols, J->ptr, J->col);
    s->order = sga_take(&s->mem, c * sizeof *s->order);
    s->from = sga_zeros(&s->mem, c, sizeof *s->from);
    s->column = sga_zeros(&s->mem, c, sizeof *s->column);
    s->left = sga_zeros(&s->mem, c, sizeof *s->left);
    s->D = sga_zeros(&s->mem, c, sizeof *s->D);
    s->y = sga_zeros(&s->mem, c, sizeof *s->y);
    bool ok = !too_many_products(J, &t) && find_order(s, &t);
    if (ok) {
        list_products(s, &t);
        ok = find_pattern(s);
    }
    if (ok)
        return s;
    lin_normal_free(s);
    return NULL;
}

void lin_normal_free(struct lin_normal *s)
{
    if (!s)
        return;
    lin_sparse_free(s->J);
    free(s->product);
    sga_arena_end(&s->mem);
    free(s);
}

/* Row by row: L y = the row's products, then l = y / D. */
static bool factor(struct lin_normal *s, const double *val)
{
    double *y = s->y;
    for (int k = 0; k < s->c; k++) {
        y[k] = 0;
        for (int p = s->from[k]; p < s->from[k + 1]; p++)
            y[s->product[p].j] += val[s->product[p].a] * val[s->product[p].b];
        double d = y[k], whole = d;
        y[k] = 0;
        for (int p = s->left[k]; p < s->left[k + 1]; p++) {
            int i = s->at[p], end = s->place[p];
            double yi = y[i];
            y[i] = 0;
            for (int q = s->column[i]; q < end; q++)
                y[s->row[q]] -= s->L[q] * yi;
            s->L[end] = yi / s->D[i];
            d -= s->L[end] * yi;
        }
        s->D[k] = d;
        if (!(d > LEAST_PIVOT * whole))
            return false;
    }
    return true;
}

bool lin_normal_step(struct lin_normal *s, const double *val, const double *r, double *d)
{
    double *y = s->y;
    bool ok = factor(s, val);
    if (ok) {
        for (int k = 0; k < s->c; k++)
            y[k] = -r[s->order[k]];
        for (int i = 0; i < s->c; i++)
            for (int q = s->column[i]; q < s->column[i + 1]; q++)
                y[s->row[q]] -= s->L[q] * y[i];
        for (int i = s->c - 1; i >= 0; i--) {
            y[i] /= s->D[i];
            for (int q = s->column[i]; q < s->column[i + 1]; q++)
                y[i] -= s->L[q] * y[s->row[q]];
        }
        memset(d, 0, (size_t)s->n * sizeof *d);
        for (int k = 0; k < s->c; k++)
            for (int e = s->J->ptr[s->order[k]]; e < s->J->ptr[s->order[k] + 1]; e++)
                d[s->J->col[e]] += val[e] * y[k];
    }
    memset(y, 0, (size_t)s->c * sizeof *y);
    return ok && lin_all_finite(s->n, d);
}
