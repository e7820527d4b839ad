/* Matrices of rationals or of balls. */
#include "linear_matrix.h"

#include <assert.h>

#include "arb_ends.h"
#include "flint_ends.h"

void linear_matrix_init(struct linear_matrix *m, int rows, int cols)
{
    m->exact = true;
    fmpq_mat_init(m->q, rows, cols);
    arb_mat_init(m->b, rows, cols);
}

void linear_matrix_clear(struct linear_matrix *m)
{
    fmpq_mat_clear(m->q);
    arb_mat_clear(m->b);
    *m = (struct linear_matrix){ .exact = false };
}

void linear_matrix_enclose(struct linear_matrix *m)
{
    assert(m->exact);
    arb_mat_set_fmpq_mat(m->b, m->q, LINEAR_BITS);
}

static void copy_entry(struct linear_matrix *to, int r, int c, const struct linear_matrix *from, int i, int k)
{
    if (to->exact)
        fmpq_set(fmpq_mat_entry(to->q, r, c), fmpq_mat_entry(from->q, i, k));
    arb_set(arb_mat_entry(to->b, r, c), arb_mat_entry(from->b, i, k));
}

void linear_matrix_columns(struct linear_matrix *out, const struct linear_matrix *a, const int *col, int cols)
{
    linear_matrix_init(out, linear_rows(a), cols);
    out->exact = a->exact;
    for (int i = 0; i < linear_rows(a); i++)
        for (int k = 0; k < cols; k++)
            copy_entry(out, i, k, a, i, col[k]);
}

void linear_matrix_rows(struct linear_matrix *out, const struct linear_matrix *a, const int *row, int rows)
{
    linear_matrix_init(out, rows, linear_cols(a));
    out->exact = a->exact;
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < linear_cols(a); k++)
            copy_entry(out, i, k, a, row[i], k);
}

void linear_matrix_product(struct linear_matrix *out, const struct linear_matrix *a, const struct linear_matrix *b)
{
    assert(linear_cols(a) == linear_rows(b));
    linear_matrix_init(out, linear_rows(a), linear_cols(b));
    out->exact = a->exact && b->exact;
    if (out->exact)
        fmpq_mat_mul(out->q, a->q, b->q);
    if (out->exact)
        linear_matrix_enclose(out);
    else
        arb_mat_mul(out->b, a->b, b->b, LINEAR_BITS);
}

void linear_matrix_add(struct linear_matrix *a, const struct linear_matrix *b, bool minus)
{
    assert(linear_rows(a) == linear_rows(b) && linear_cols(a) == linear_cols(b));
    a->exact = a->exact && b->exact;
    if (a->exact) {
        (minus ? fmpq_mat_sub : fmpq_mat_add)(a->q, a->q, b->q);
        linear_matrix_enclose(a);
    } else {
        (minus ? arb_mat_sub : arb_mat_add)(a->b, a->b, b->b, LINEAR_BITS);
    }
}

bool linear_matrix_solve(struct linear_matrix *out, const struct linear_matrix *a, const struct linear_matrix *b)
{
    assert(linear_rows(a) == linear_cols(a) && linear_rows(a) == linear_rows(b));
    linear_matrix_init(out, linear_rows(a), linear_cols(b));
    out->exact = a->exact && b->exact;
    if (!linear_rows(a))
        return true;
    if (!out->exact)
        return arb_mat_solve(out->b, a->b, b->b, LINEAR_BITS);
    bool regular = fmpq_mat_solve(out->q, a->q, b->q);
    linear_matrix_enclose(out);
    return regular;
}

/* The largest entry that is not 0 for sure, of rows and columns from `from` on; false: there is none. */
static bool largest(const arb_mat_t m, slong from, slong *row, slong *col)
{
    SGA_ENDS(arf_end) arf_t best = { 0 }, low = { 0 };
    SGA_ENDS(mag_end) mag_t size = { 0 };
    bool found = false;
    for (slong i = from; i < arb_mat_nrows(m); i++)
        for (slong k = from; k < arb_mat_ncols(m); k++) {
            arb_get_mag_lower(size, arb_mat_entry(m, i, k));
            arf_set_mag(low, size);
            if (arf_cmp(low, best) <= 0)
                continue;
            arf_set(best, low);
            *row = i;
            *col = k;
            found = true;
        }
    return found;
}

static void eliminate(arb_mat_t m, slong at)
{
    SGA_ENDS(arb_end) arb_t factor = { 0 };
    for (slong i = at + 1; i < arb_mat_nrows(m); i++) {
        arb_div(factor, arb_mat_entry(m, i, at), arb_mat_entry(m, at, at), 2 * LINEAR_BITS);
        for (slong k = at + 1; k < arb_mat_ncols(m); k++)
            arb_submul(arb_mat_entry(m, i, k), factor, arb_mat_entry(m, at, k), 2 * LINEAR_BITS);
    }
}

static bool rest_is_zero(const arb_mat_t m, slong from)
{
    for (slong i = from; i < arb_mat_nrows(m); i++)
        for (slong k = from; k < arb_mat_ncols(m); k++)
            if (!arb_is_zero(arb_mat_entry(m, i, k)))
                return false;
    return true;
}

bool linear_matrix_rank(const struct linear_matrix *a, int *least)
{
    slong rank = 0, row = 0, col = 0;
    if (a->exact) {
        SGA_ENDS(fmpq_mat_end) fmpq_mat_t q;
        fmpq_mat_init(q, linear_rows(a), linear_cols(a));
        *least = (int)fmpq_mat_rref(q, a->q);
        return true;
    }
    SGA_ENDS(arb_mat_end) arb_mat_t m;
    arb_mat_init(m, linear_rows(a), linear_cols(a));
    arb_mat_set(m, a->b);
    for (; largest(m, rank, &row, &col); rank++) {
        if (row != rank)
            arb_mat_swap_rows(m, NULL, row, rank);
        for (slong i = 0; i < arb_mat_nrows(m) && col != rank; i++)
            arb_swap(arb_mat_entry(m, i, col), arb_mat_entry(m, i, rank));
        eliminate(m, rank);
    }
    *least = (int)rank;
    return rest_is_zero(m, rank);
}

double linear_matrix_double(const struct linear_matrix *m, int row, int col)
{
    return arf_get_d(arb_midref(arb_mat_entry(m->b, row, col)), ARF_RND_NEAR);
}

double linear_matrix_error(const struct linear_matrix *m)
{
    SGA_ENDS(arb_end) arb_t off = { 0 };
    SGA_ENDS(mag_end) mag_t size = { 0 };
    double worst = 0;
    for (int i = 0; i < linear_rows(m); i++)
        for (int k = 0; k < linear_cols(m); k++) {
            arb_set_d(off, linear_matrix_double(m, i, k));
            arb_sub(off, arb_mat_entry(m->b, i, k), off, LINEAR_BITS);
            arb_get_mag(size, off);
            double e = mag_get_d(size);
            worst = e > worst ? e : worst;
        }
    return worst;
}
