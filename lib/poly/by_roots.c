/* Rouillier's rational univariate representation, from traces. */
#include "hermite.h"

#include <assert.h>
#include <flint/fmpq_poly.h>

#include "flint_ends.h"
#include "real_zeros.h"

/* Forms that are tried: coefficients 1, c, c^2, ... A form fails where two zeros have one value of it: for fewer c than pairs of zeros, times variables. */
enum { FORMS = 12 };

/* Multiplication by the form. */
static void form_matrix(const struct hermite *h, int c, fmpq_mat_t out)
{
    SGA_ENDS(fmpq_mat_end) fmpq_mat_t term;
    SGA_ENDS(fmpz_end) fmpz_t power = { 0 };
    fmpq_mat_init(term, h->count, h->count);
    fmpq_mat_zero(out);
    fmpz_one(power);
    for (int v = 0; v < h->I->n; v++) {
        fmpq_mat_scalar_mul_fmpz(term, h->times + v, power);
        fmpq_mat_add(out, out, term);
        fmpz_mul_si(power, power, c);
    }
}

/* The squarefree part of the characteristic polynomial, monic. */
static void values_of(const fmpq_mat_t form, fmpq_poly_t out)
{
    SGA_ENDS(fmpq_poly_end) fmpq_poly_t chi = { { 0 } }, common = { { 0 } };
    fmpq_poly_init(chi);
    fmpq_poly_init(common);
    fmpq_mat_charpoly(chi, form);
    fmpq_poly_derivative(common, chi);
    fmpq_poly_gcd(common, common, chi);
    fmpq_poly_div(out, chi, common);
    fmpq_poly_make_monic(out, out);
}

/* By power i of the form below d: its coordinates among the monomials, in column i. */
static void powers(const struct hermite *h, const fmpq_mat_t form, long d, fmpq_mat_t out)
{
    SGA_ENDS(fmpq_mat_end) fmpq_mat_t last, next;
    fmpq_mat_init(last, h->count, 1);
    fmpq_mat_init(next, h->count, 1);
    fmpq_set_si(fmpq_mat_entry(last, 0, 0), 1, 1);
    for (long i = 0; i < d; i++) {
        for (int k = 0; k < h->count; k++)
            fmpq_set(fmpq_mat_entry(out, k, i), fmpq_mat_entry(last, k, 0));
        fmpq_mat_mul(next, form, last);
        fmpq_mat_swap(next, last);
    }
}

/* sum over i of trace(v form^i) H_{d-1-i}(T), H_j the j-th polynomial of Horner's rule for p; v: multiplication by a variable, NULL: 1. */
static void numerator(const struct hermite *h, const fmpq_mat_struct *v, const fmpq_mat_t powers, const fmpq_poly_t p, fmpq_poly_t out)
{
    long d = fmpq_poly_degree(p);
    SGA_ENDS(fmpq_mat_end) fmpq_mat_t row, traces;
    SGA_ENDS(fmpq_poly_end) fmpq_poly_t horner = { { 0 } }, term = { { 0 } };
    SGA_ENDS(fmpq_end) fmpq_t a = { { 0, 1 } };
    fmpq_mat_init(row, 1, h->count);
    fmpq_mat_init(traces, 1, d);
    fmpq_poly_init(horner);
    fmpq_poly_init(term);
    if (v)
        fmpq_mat_mul(row, h->trace, v);
    else
        fmpq_mat_set(row, h->trace);
    fmpq_poly_zero(out);
    fmpq_mat_mul(traces, row, powers);
    for (long i = d - 1; i >= 0; i--) {           /* H_0 = 1 stands with the highest power */
        fmpq_poly_shift_left(horner, horner, 1);
        fmpq_poly_get_coeff_fmpq(a, p, i + 1);
        fmpq_poly_set_fmpq(term, a);
        fmpq_poly_add(horner, horner, term);
        fmpq_poly_scalar_mul_fmpq(term, horner, fmpq_mat_entry(traces, 0, i));
        fmpq_poly_add(out, out, term);
    }
}

static void end_poly(fmpz_poly_struct *p)
{
    fmpz_poly_clear(p);
}

/* All numerators over one denominator, so that quotients stay. */
static void keep(const struct hermite *h, const fmpq_mat_t form, const fmpq_poly_t p, struct poly_real_zeros *out)
{
    SGA_ENDS(fmpq_mat_end) fmpq_mat_t power;
    SGA_ENDS(fmpq_poly_end) fmpq_poly_t g = { { 0 } };
    SGA_ENDS(fmpz_end) fmpz_t scale = { 0 };
    fmpq_mat_init(power, h->count, fmpq_poly_degree(p));
    fmpq_poly_init(g);
    powers(h, form, fmpq_poly_degree(p), power);
    fmpq_poly_get_numerator(out->root, p);
    numerator(h, NULL, power, p, g);
    fmpz_set(scale, fmpq_poly_denref(g));
    fmpq_poly_get_numerator(out->below, g);
    out->over = sga_take(&out->mem, ((size_t)h->I->n + 1) * sizeof *out->over);
    for (int v = 0; v < h->I->n; v++) {
        fmpz_poly_init(out->over + v);
        SGA_AT_END(&out->mem, end_poly, out->over + v);
        numerator(h, h->times + v, power, p, g);
        fmpq_poly_scalar_mul_fmpz(g, g, scale);
        fmpz_poly_scalar_mul_fmpz(out->below, out->below, fmpq_poly_denref(g));
        for (int w = 0; w < v; w++)
            fmpz_poly_scalar_mul_fmpz(out->over + w, out->over + w, fmpq_poly_denref(g));
        fmpz_mul(scale, scale, fmpq_poly_denref(g));
        fmpq_poly_get_numerator(out->over + v, g);
    }
}

bool hermite_by_roots(const struct hermite *h, long complex_zeros, struct poly_real_zeros *out)
{
    SGA_ENDS(fmpq_mat_end) fmpq_mat_t form;
    SGA_ENDS(fmpq_poly_end) fmpq_poly_t p = { { 0 } };
    fmpq_mat_init(form, h->count, h->count);
    fmpq_poly_init(p);
    assert(complex_zeros > 0);
    for (int c = 1; c <= FORMS; c++) {
        form_matrix(h, c, form);
        values_of(form, p);
        if (fmpq_poly_degree(p) < complex_zeros)
            continue;
        keep(h, form, p, out);
        return true;
    }
    return false;
}
