/* Matrices over Q(t): sums, products, linear systems. */
#include "ratio_matrix.h"

#include <assert.h>
#include <stdlib.h>

#include <flint/fmpz_poly_mat.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"

void ratio_matrix_init(struct ratio_matrix *m, int rows, int cols)
{
    m->rows = rows;
    m->cols = cols;
    m->e = sga_malloc(((size_t)rows * (size_t)cols + 1) * sizeof *m->e);
    for (int k = 0; k < rows * cols; k++)
        fmpz_poly_q_init(m->e + k);
}

void ratio_matrix_clear(struct ratio_matrix *m)
{
    for (int k = 0; k < m->rows * m->cols && m->e; k++)
        fmpz_poly_q_clear(m->e + k);
    free(m->e);
    *m = (struct ratio_matrix){ 0 };
}

void ratio_matrix_set(struct ratio_matrix *m, const struct ratio_matrix *a)
{
    if (m == a)
        return;
    ratio_matrix_clear(m);
    ratio_matrix_init(m, a->rows, a->cols);
    for (int k = 0; k < a->rows * a->cols; k++)
        fmpz_poly_q_set(m->e + k, a->e + k);
}

void ratio_matrix_swap(struct ratio_matrix *m, struct ratio_matrix *a)
{
    struct ratio_matrix keep = *m;
    *m = *a;
    *a = keep;
}

bool ratio_matrix_is_zero(const struct ratio_matrix *m)
{
    bool zero = true;
    for (int k = 0; k < m->rows * m->cols && zero; k++)
        zero = fmpz_poly_q_is_zero(m->e + k);
    return zero;
}

bool ratio_matrix_equal(const struct ratio_matrix *a, const struct ratio_matrix *b)
{
    bool same = a->rows == b->rows && a->cols == b->cols;
    for (int k = 0; same && k < a->rows * a->cols; k++)
        same = fmpz_poly_q_equal(a->e + k, b->e + k);
    return same;
}

void ratio_matrix_derive(struct ratio_matrix *m, const struct ratio_matrix *a)
{
    ratio_matrix_set(m, a);
    for (int k = 0; k < m->rows * m->cols; k++)
        fmpz_poly_q_derivative(m->e + k, m->e + k);
}

void ratio_matrix_add(struct ratio_matrix *m, const struct ratio_matrix *a)
{
    assert(m->rows == a->rows && m->cols == a->cols);
    for (int k = 0; k < m->rows * m->cols; k++)
        fmpz_poly_q_add(m->e + k, m->e + k, a->e + k);
}

void ratio_matrix_sub(struct ratio_matrix *m, const struct ratio_matrix *a)
{
    assert(m->rows == a->rows && m->cols == a->cols);
    for (int k = 0; k < m->rows * m->cols; k++)
        fmpz_poly_q_sub(m->e + k, m->e + k, a->e + k);
}

void ratio_matrix_scale(struct ratio_matrix *m, long factor)
{
    for (int k = 0; k < m->rows * m->cols; k++)
        fmpz_poly_q_scalar_mul_si(m->e + k, m->e + k, factor);
}

void ratio_matrix_addmul(struct ratio_matrix *m, const struct ratio_matrix *a, const struct ratio_matrix *b)
{
    assert(a->cols == b->rows && m->rows == a->rows && m->cols == b->cols);
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t p;
    fmpz_poly_q_init(p);
    for (int i = 0; i < a->rows; i++)
        for (int k = 0; k < a->cols; k++) {
            if (fmpz_poly_q_is_zero(ratio_at(a, i, k)))
                continue;
            for (int j = 0; j < b->cols; j++) {
                if (fmpz_poly_q_is_zero(ratio_at(b, k, j)))
                    continue;
                fmpz_poly_q_mul(p, ratio_at(a, i, k), ratio_at(b, k, j));
                fmpz_poly_q_add(ratio_at(m, i, j), ratio_at(m, i, j), p);
            }
        }
}

/* Column j of m as polynomials over l, the lcm of its denominators. */
static void column_over(fmpz_poly_mat_t out, fmpz_poly_t l, const struct ratio_matrix *m, int j)
{
    fmpz_poly_one(l);
    for (int i = 0; i < m->rows; i++)
        if (!fmpz_poly_is_one(fmpz_poly_q_denref(ratio_at(m, i, j))))
            fmpz_poly_lcm(l, l, fmpz_poly_q_denref(ratio_at(m, i, j)));
    for (int i = 0; i < m->rows; i++) {
        fmpz_poly_struct *to = fmpz_poly_mat_entry(out, i, j);
        fmpz_poly_div(to, l, fmpz_poly_q_denref(ratio_at(m, i, j)));
        fmpz_poly_mul(to, to, fmpz_poly_q_numref(ratio_at(m, i, j)));
    }
}

/* a = A diag(1/k), b = B diag(1/l), A X = den B': x_ij = k_i X_ij / (den l_j). */
static void scale_back(struct ratio_matrix *x, const fmpz_poly_mat_t X, const fmpz_poly_t den, const fmpz_poly_struct *k,
                       const fmpz_poly_struct *l)
{
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t f;
    fmpz_poly_q_init(f);
    for (int i = 0; i < x->rows; i++)
        for (int j = 0; j < x->cols; j++) {
            fmpz_poly_q_struct *to = ratio_at(x, i, j);
            fmpz_poly_set(fmpz_poly_q_numref(to), fmpz_poly_mat_entry(X, i, j));
            fmpz_poly_set(fmpz_poly_q_denref(to), den);
            fmpz_poly_q_canonicalise(to);
            fmpz_poly_set(fmpz_poly_q_numref(f), k + i);
            fmpz_poly_set(fmpz_poly_q_denref(f), l + j);
            fmpz_poly_q_canonicalise(f);
            fmpz_poly_q_mul(to, to, f);
        }
}

static fmpz_poly_struct *new_polys(int n)
{
    fmpz_poly_struct *p = sga_malloc((size_t)(n + 1) * sizeof *p);
    for (int i = 0; i < n; i++)
        fmpz_poly_init(p + i);
    return p;
}

static void free_polys(fmpz_poly_struct *p, int n)
{
    for (int i = 0; i < n; i++)
        fmpz_poly_clear(p + i);
    free(p);
}

bool ratio_matrix_solve(struct ratio_matrix *x, const struct ratio_matrix *a, const struct ratio_matrix *b)
{
    assert(a->rows == a->cols && b->rows == a->rows);
    SGA_ENDS(fmpz_poly_mat_end) fmpz_poly_mat_t A, B, X;
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t den = { 0 };
    int n = a->rows, cols = b->cols;
    fmpz_poly_struct *k = new_polys(n), *l = new_polys(cols);
    fmpz_poly_mat_init(A, n, n);
    fmpz_poly_mat_init(B, n, cols);
    fmpz_poly_mat_init(X, n, cols);
    fmpz_poly_one(den);
    for (int j = 0; j < n; j++)
        column_over(A, k + j, a, j);
    for (int j = 0; j < cols; j++)
        column_over(B, l + j, b, j);
    bool ok = n == 0 || fmpz_poly_mat_solve(X, den, A, B);
    if (ok) {
        SGA_ENDS(ratio_matrix_clear) struct ratio_matrix r;
        ratio_matrix_init(&r, n, cols);
        scale_back(&r, X, den, k, l);
        ratio_matrix_swap(x, &r);
    }
    free_polys(k, n);
    free_polys(l, cols);
    return ok;
}
