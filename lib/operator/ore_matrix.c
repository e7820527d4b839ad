/* Matrices over k[D]: products, adjoints, elementary operations. */
#include "ore_matrix.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "mem.h"

void ore_matrix_init(struct ore_matrix *m, int rows, int cols)
{
    m->rows = rows;
    m->cols = cols;
    m->e = sga_calloc((size_t)rows * (size_t)cols + 1, sizeof *m->e);
}

void ore_matrix_clear(struct ore_matrix *m)
{
    for (int k = 0; k < m->rows * m->cols && m->e; k++)
        ore_clear(m->e + k);
    free(m->e);
    *m = (struct ore_matrix){ 0 };
}

static void resize(struct ore_matrix *m, int rows, int cols)
{
    ore_matrix_clear(m);
    ore_matrix_init(m, rows, cols);
}

void ore_matrix_set(struct ore_matrix *m, const struct ore_matrix *a)
{
    if (m == a)
        return;
    resize(m, a->rows, a->cols);
    for (int k = 0; k < a->rows * a->cols; k++)
        ore_set(m->e + k, a->e + k);
}

void ore_matrix_swap(struct ore_matrix *m, struct ore_matrix *a)
{
    struct ore_matrix keep = *m;
    *m = *a;
    *a = keep;
}

void ore_matrix_identity(struct ore_matrix *m, int n)
{
    resize(m, n, n);
    for (int i = 0; i < n; i++)
        ore_one(ore_at(m, i, i));
}

bool ore_matrix_equal(const struct ore_matrix *a, const struct ore_matrix *b)
{
    bool same = a->rows == b->rows && a->cols == b->cols;
    for (int k = 0; same && k < a->rows * a->cols; k++)
        same = ore_equal(a->e + k, b->e + k);
    return same;
}

bool ore_matrix_is_identity(const struct ore_matrix *a)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix one = { 0 };
    ore_matrix_identity(&one, a->rows);
    return ore_matrix_equal(a, &one);
}

void ore_matrix_mul(struct ore_matrix *m, const struct ore_matrix *a, const struct ore_matrix *b)
{
    assert(a->cols == b->rows && m != a && m != b);
    resize(m, a->rows, b->cols);
    for (int i = 0; i < a->rows; i++)
        for (int j = 0; j < b->cols; j++)
            for (int k = 0; k < a->cols; k++)
                ore_addmul(ore_at(m, i, j), ore_at(a, i, k), ore_at(b, k, j));
}

void ore_matrix_adjoint(struct ore_matrix *m, const struct ore_matrix *a)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix r = { 0 };
    ore_matrix_init(&r, a->cols, a->rows);
    for (int i = 0; i < a->rows; i++)
        for (int j = 0; j < a->cols; j++)
            ore_adjoint(ore_at(&r, j, i), ore_at(a, i, j));
    ore_matrix_swap(m, &r);
}

void ore_matrix_add_row(struct ore_matrix *m, int i, const struct ore *q, int j)
{
    assert(i != j);
    for (int k = 0; k < m->cols; k++)
        ore_addmul(ore_at(m, i, k), q, ore_at(m, j, k));
}

void ore_matrix_sub_col(struct ore_matrix *m, int j, const struct ore *q, int i)
{
    assert(i != j);
    for (int k = 0; k < m->rows; k++)
        ore_submul(ore_at(m, k, j), ore_at(m, k, i), q);
}

void ore_matrix_swap_rows(struct ore_matrix *m, int i, int j)
{
    for (int k = 0; k < m->cols && i != j; k++)
        ore_swap(ore_at(m, i, k), ore_at(m, j, k));
}

void ore_matrix_swap_cols(struct ore_matrix *m, int i, int j)
{
    for (int k = 0; k < m->rows && i != j; k++)
        ore_swap(ore_at(m, k, i), ore_at(m, k, j));
}

void ore_matrix_scale_row(struct ore_matrix *m, int i, const fmpz_poly_q_t c)
{
    for (int k = 0; k < m->cols; k++)
        ore_scale(ore_at(m, i, k), c);
}

void ore_matrix_scale_col(struct ore_matrix *m, int i, const fmpz_poly_q_t c)
{
    SGA_ENDS(ore_clear) struct ore factor;
    ore_init(&factor);
    ore_add_term(&factor, c, 0);
    for (int k = 0; k < m->rows; k++)
        ore_mul(ore_at(m, k, i), ore_at(m, k, i), &factor);
}

int ore_matrix_order(const struct ore_matrix *m)
{
    int order = -1;
    for (int k = 0; k < m->rows * m->cols; k++)
        order = ore_order(m->e + k) > order ? ore_order(m->e + k) : order;
    return order;
}

size_t ore_matrix_size(const struct ore_matrix *m)
{
    size_t bytes = 0;
    for (int k = 0; k < m->rows * m->cols; k++)
        bytes += ore_size(m->e + k);
    return bytes;
}
