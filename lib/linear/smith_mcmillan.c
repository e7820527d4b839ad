/* The Smith-McMillan form of a rational matrix: G = N/d with a polynomial matrix N, whose Smith form over Q[s] is found by Euclid's algorithm on
 * rows and columns; its invariant factors over d, reduced, are the zeros' and the poles'. */
#include "transfer_matrix.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"

/* A small matrix of polynomials over Q. */
struct smith {
    fmpq_poly_struct *a;
    int rows, cols;
};

static fmpq_poly_struct *at(const struct smith *m, int row, int col)
{
    return m->a + row * m->cols + col;
}

static void swap_rows(struct smith *m, int i, int k)
{
    for (int c = 0; c < m->cols && i != k; c++)
        fmpq_poly_swap(at(m, i, c), at(m, k, c));
}

static void swap_cols(struct smith *m, int i, int k)
{
    for (int r = 0; r < m->rows && i != k; r++)
        fmpq_poly_swap(at(m, r, i), at(m, r, k));
}

/* The entry of least degree from (t, t) on to (t, t), monic; false: all are 0. */
static bool take_least(struct smith *m, int t)
{
    int row = -1, col = -1;
    for (int i = t; i < m->rows; i++)
        for (int k = t; k < m->cols; k++)
            if (!fmpq_poly_is_zero(at(m, i, k)) && (row < 0 || fmpq_poly_degree(at(m, i, k)) < fmpq_poly_degree(at(m, row, col)))) {
                row = i;
                col = k;
            }
    if (row < 0)
        return false;
    SGA_ENDS(fmpq_end) fmpq_t lead = { { 0, 1 } };
    swap_rows(m, t, row);
    swap_cols(m, t, col);
    fmpq_poly_get_coeff_fmpq(lead, at(m, t, t), fmpq_poly_degree(at(m, t, t)));
    for (int k = t; k < m->cols; k++)
        fmpq_poly_scalar_div_fmpq(at(m, t, k), at(m, t, k), lead);
    return true;
}

/* Row and column t are reduced by (t, t). Whether all remainders are 0. */
static bool clear_cross(struct smith *m, int t)
{
    SGA_ENDS(fmpq_poly_end) fmpq_poly_t q, p;
    bool clear = true;
    fmpq_poly_init(q);
    fmpq_poly_init(p);
    for (int i = t + 1; i < m->rows; i++) {
        fmpq_poly_div(q, at(m, i, t), at(m, t, t));
        for (int k = t; k < m->cols; k++) {
            fmpq_poly_mul(p, q, at(m, t, k));
            fmpq_poly_sub(at(m, i, k), at(m, i, k), p);
        }
        clear = clear && fmpq_poly_is_zero(at(m, i, t));
    }
    for (int k = t + 1; k < m->cols; k++) {
        fmpq_poly_div(q, at(m, t, k), at(m, t, t));
        for (int i = t; i < m->rows; i++) {
            fmpq_poly_mul(p, q, at(m, i, t));
            fmpq_poly_sub(at(m, i, k), at(m, i, k), p);
        }
        clear = clear && fmpq_poly_is_zero(at(m, t, k));
    }
    return clear;
}

/* A row with an entry that (t, t) does not divide is added to row t; false: it divides all. */
static bool mix(struct smith *m, int t)
{
    SGA_ENDS(fmpq_poly_end) fmpq_poly_t r;
    fmpq_poly_init(r);
    for (int i = t + 1; i < m->rows; i++)
        for (int k = t + 1; k < m->cols; k++) {
            fmpq_poly_rem(r, at(m, i, k), at(m, t, t));
            if (fmpq_poly_is_zero(r))
                continue;
            for (int c = t; c < m->cols; c++)
                fmpq_poly_add(at(m, t, c), at(m, t, c), at(m, i, c));
            return true;
        }
    return false;
}

/* The rank: so many invariant factors stand on the diagonal. */
static int smith_form(struct smith *m)
{
    int t = 0;
    while (t < m->rows && t < m->cols && take_least(m, t))
        if (clear_cross(m, t) && !mix(m, t))
            t++;
    return t;
}

/* Roots with multiplicities, of a companion matrix. */
static bool roots(const fmpq_poly_t p, struct spectrum_of *out, const struct sga_budget *budget, struct sga_error *err)
{
    int n = (int)fmpq_poly_degree(p);
    struct linear_matrix companion;
    SGA_ENDS(fmpq_end) fmpq_t lead = { { 0, 1 } };
    linear_matrix_init(&companion, n, n);
    fmpq_poly_get_coeff_fmpq(lead, p, n);
    for (int i = 0; i < n; i++) {
        fmpq *c = fmpq_mat_entry(companion.q, i, n - 1);
        fmpq_poly_get_coeff_fmpq(c, p, i);
        fmpq_div(c, c, lead);
        fmpq_neg(c, c);
        if (i)
            fmpq_one(fmpq_mat_entry(companion.q, i, i - 1));
    }
    linear_matrix_enclose(&companion);
    bool ok = spectrum_of_matrix(out, &companion, budget, err);
    linear_matrix_clear(&companion);
    return ok;
}

static void numerators(const struct transfer_matrix *t, struct smith *m, const fmpz_poly_t d)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t p = { 0 };
    for (int k = 0; k < t->outputs * t->inputs; k++) {
        fmpz_poly_div(p, d, t->den + k);
        fmpz_poly_mul(p, p, t->num + k);
        fmpq_poly_set_fmpz_poly(m->a + k, p);
    }
}

bool transfer_matrix_poles(const struct transfer_matrix *t, struct spectrum_of *poles, struct spectrum_of *zeros, const struct sga_budget *budget,
                           struct sga_error *err)
{
    struct smith m = { .rows = t->outputs, .cols = t->inputs };
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t d = { 0 };
    SGA_ENDS(fmpq_poly_end) fmpq_poly_t above, below, g, q, whole;
    SGA_ARENA(mem);
    m.a = sga_take(&mem, ((size_t)(m.rows * m.cols) + 1) * sizeof *m.a);
    for (int k = 0; k < m.rows * m.cols; k++)
        fmpq_poly_init(m.a + k);
    fmpq_poly_init(above);
    fmpq_poly_init(below);
    fmpq_poly_init(g);
    fmpq_poly_init(q);
    fmpq_poly_init(whole);
    fmpz_poly_one(d);
    for (int k = 0; k < m.rows * m.cols; k++)
        fmpz_poly_lcm(d, d, t->den + k);
    numerators(t, &m, d);
    fmpq_poly_one(above);
    fmpq_poly_one(below);
    fmpq_poly_set_fmpz_poly(whole, d);
    int rank = smith_form(&m);
    for (int i = 0; i < rank; i++) {
        fmpq_poly_gcd(g, at(&m, i, i), whole);
        fmpq_poly_div(q, at(&m, i, i), g);
        fmpq_poly_mul(above, above, q);
        fmpq_poly_div(q, whole, g);
        fmpq_poly_mul(below, below, q);
    }
    for (int k = 0; k < m.rows * m.cols; k++)
        fmpq_poly_clear(m.a + k);
    return roots(below, poles, budget, err) && roots(above, zeros, budget, err);
}
