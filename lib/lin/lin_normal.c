/* Sparse L D L^T of J J^T; see the header. */
#include "lin_normal.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "lin_gram.h"
#include "lin_sparse.h"
#include "mem.h"

/* What is left of a row's squared length once the rows before it are taken out. */
static const double LEAST_PIVOT = 1e-6;
enum { MOST_PRODUCTS = 48, MOST_FILL = 16 };

struct lin_normal {
    struct sga_arena mem;
    int c, n;
    struct lin_sparse *J;          /* the pattern */
    struct lin_gram g;
    double *L, *D, *y;             /* y: 0 between rows */
};

struct lin_normal *lin_normal_new(const struct lin_sparse *J)
{
    struct lin_normal *s = sga_calloc(1, sizeof *s);
    size_t c = (size_t)J->rows + 1;
    s->c = J->rows;
    s->n = J->cols;
    if (!lin_gram_init(&s->g, J, (struct lin_gram_most){ MOST_PRODUCTS, MOST_FILL })) {
        lin_normal_free(s);
        return NULL;
    }
    s->J = lin_sparse_new(J->rows, J->cols, J->ptr, J->col);
    s->L = sga_zeros(&s->mem, (size_t)s->g.column[s->c] + 1, sizeof *s->L);
    s->D = sga_zeros(&s->mem, c, sizeof *s->D);
    s->y = sga_zeros(&s->mem, c, sizeof *s->y);
    return s;
}

void lin_normal_free(struct lin_normal *s)
{
    if (!s)
        return;
    lin_sparse_free(s->J);
    lin_gram_clear(&s->g);
    sga_arena_end(&s->mem);
    free(s);
}

/* Row by row: L y = the row's products, then l = y / D. */
static bool factor(struct lin_normal *s, const double *val)
{
    const struct lin_gram *g = &s->g;
    double *y = s->y;
    for (int k = 0; k < s->c; k++) {
        y[k] = 0;
        for (int p = g->from[k]; p < g->from[k + 1]; p++)
            y[g->product[p].j] += val[g->product[p].a] * val[g->product[p].b];
        double d = y[k], whole = d;
        y[k] = 0;
        for (int p = g->left[k]; p < g->left[k + 1]; p++) {
            int i = g->at[p], end = g->place[p];
            double yi = y[i];
            y[i] = 0;
            for (int q = g->column[i]; q < end; q++)
                y[g->row[q]] -= s->L[q] * yi;
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
    const struct lin_gram *g = &s->g;
    double *y = s->y;
    bool ok = factor(s, val);
    if (ok) {
        for (int k = 0; k < s->c; k++)
            y[k] = -r[g->order[k]];
        for (int i = 0; i < s->c; i++)
            for (int q = g->column[i]; q < g->column[i + 1]; q++)
                y[g->row[q]] -= s->L[q] * y[i];
        for (int i = s->c - 1; i >= 0; i--) {
            y[i] /= s->D[i];
            for (int q = g->column[i]; q < g->column[i + 1]; q++)
                y[i] -= s->L[q] * y[g->row[q]];
        }
        memset(d, 0, (size_t)s->n * sizeof *d);
        for (int k = 0; k < s->c; k++)
            for (int e = s->J->ptr[g->order[k]]; e < s->J->ptr[g->order[k] + 1]; e++)
                d[s->J->col[e]] += val[e] * y[k];
    }
    memset(y, 0, (size_t)s->c * sizeof *y);
    return ok && lin_all_finite(s->n, d);
}
