/* Sparse L D L^T of J J^T; see the header. */
#include "lin_normal.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/ldl.h>

#include "arena.h"
#include "lin_gram.h"
#include "lin_sparse.h"
#include "mem.h"

/* What is left of a row's length once the rows before it are taken out. */
static const double LEAST_LEFT = 1e-3;
enum { MOST_PRODUCTS = 48, MOST_FILL = 40 };

struct lin_normal {
    struct sga_arena mem;
    int c, n;
    struct lin_sparse *J;          /* the pattern */
    struct lin_gram g;
    int *ptr, *row, *at;           /* J J^T by columns down to the diagonal, which comes last; the entry of each product of g */
    double *a;                     /* its values */
    double *val;                   /* of J, that it has been factored for, if it has */
    bool factored;
    double left;                   /* the least part of a row's squared length that was left */
    int *column, *parent, *fill, *flag, *path, *below;   /* of L: LDL's Lp, Parent, Lnz, Flag, Pattern, Li */
    double *L, *D, *y;
};

/* The entries that the products of J J^T make up. */
static void place_products(struct lin_normal *s)
{
    SGA_ARENA(mem);
    const struct lin_gram *g = &s->g;
    int *where = sga_take(&mem, ((size_t)s->c + 1) * sizeof *where), count = 0;
    memset(where, -1, ((size_t)s->c + 1) * sizeof *where);
    for (int k = 0; k < s->c; k++) {
        for (int p = g->from[k]; p < g->from[k + 1]; p++) {
            int j = g->product[p].j;
            if (j != k && where[j] < s->ptr[k]) {
                where[j] = count;
                s->row[count++] = j;
            }
        }
        where[k] = count;
        s->row[count++] = k;
        for (int p = g->from[k]; p < g->from[k + 1]; p++)
            s->at[p] = where[g->product[p].j];
        s->ptr[k + 1] = count;
    }
}

struct lin_normal *lin_normal_new(const struct lin_sparse *J)
{
    struct lin_normal *s = sga_calloc(1, sizeof *s);
    struct lin_gram *g = &s->g;
    size_t c = (size_t)J->rows + 1;
    s->c = J->rows;
    s->n = J->cols;
    if (!lin_gram_init(g, J, (struct lin_gram_most){ MOST_PRODUCTS, MOST_FILL })) {
        lin_normal_free(s);
        return NULL;
    }
    s->J = lin_sparse_new(J->rows, J->cols, J->ptr, J->col);
    size_t products = (size_t)g->from[s->c], filled = (size_t)g->column[s->c] + 1;
    s->ptr = sga_zeros(&s->mem, c, sizeof *s->ptr);
    s->row = sga_zeros(&s->mem, products + c, sizeof *s->row);
    s->at = sga_zeros(&s->mem, products + 1, sizeof *s->at);
    place_products(s);
    s->val = sga_take(&s->mem, ((size_t)J->ptr[s->c] + 1) * sizeof *s->val);
    s->a = sga_zeros(&s->mem, (size_t)s->ptr[s->c] + 1, sizeof *s->a);
    s->column = sga_zeros(&s->mem, c, sizeof *s->column);
    s->parent = sga_zeros(&s->mem, c, sizeof *s->parent);
    s->fill = sga_zeros(&s->mem, c, sizeof *s->fill);
    s->flag = sga_zeros(&s->mem, c, sizeof *s->flag);
    s->path = sga_zeros(&s->mem, c, sizeof *s->path);
    ldl_symbolic(s->c, s->ptr, s->row, s->column, s->parent, s->fill, s->flag, NULL, NULL);
    assert((size_t)s->column[s->c] < filled);
    s->below = sga_zeros(&s->mem, filled, sizeof *s->below);
    s->L = sga_zeros(&s->mem, filled, sizeof *s->L);
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

const struct lin_gram *lin_normal_gram(const struct lin_normal *s)
{
    return &s->g;
}

/* LDL itself stops at a 0 alone. Values that are the same again, as those of affine constraints are, have their factors. */
bool lin_normal_factor(struct lin_normal *s, const double *val, double least)
{
    const struct lin_gram *g = &s->g;
    size_t entries = (size_t)s->J->ptr[s->c];
    if (!s->factored || memcmp(s->val, val, entries * sizeof *val) != 0) {
        memcpy(s->val, val, entries * sizeof *val);
        memset(s->a, 0, (size_t)s->ptr[s->c] * sizeof *s->a);
        for (int p = 0; p < g->from[s->c]; p++)
            s->a[s->at[p]] += val[g->product[p].a] * val[g->product[p].b];
        s->factored = true;
        s->left = INFINITY;
        if (ldl_numeric(s->c, s->ptr, s->row, s->a, s->column, s->parent, s->fill, s->below, s->L, s->D, s->y, s->path, s->flag, NULL, NULL) < s->c)
            s->left = 0;
        for (int k = 0; k < s->c && s->left > 0; k++) {
            double left = s->D[k] / s->a[s->ptr[k + 1] - 1];
            s->left = left > 0 ? fmin(s->left, left) : 0;
        }
    }
    return s->left > least * least;
}

bool lin_normal_solve(struct lin_normal *s, const double *val, const double *r, double *d)
{
    const int *order = s->g.order;
    double *y = s->y;
    for (int k = 0; k < s->c; k++)
        y[k] = -r[order[k]];
    ldl_lsolve(s->c, y, s->column, s->below, s->L);
    ldl_dsolve(s->c, y, s->D);
    ldl_ltsolve(s->c, y, s->column, s->below, s->L);
    memset(d, 0, (size_t)s->n * sizeof *d);
    for (int k = 0; k < s->c; k++)
        for (int e = s->J->ptr[order[k]]; e < s->J->ptr[order[k] + 1]; e++)
            d[s->J->col[e]] += val[e] * y[k];
    return lin_all_finite(s->n, d);
}

bool lin_normal_step(struct lin_normal *s, const double *val, const double *r, double *d)
{
    return lin_normal_factor(s, val, LEAST_LEFT) && lin_normal_solve(s, val, r, d);
}
