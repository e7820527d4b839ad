/* Standard monomials, their products, and Hermite's quadratic form. */
#include "hermite.h"

#include <assert.h>
#include <flint/fmpz_poly.h>
#include <string.h>

#include "budget.h"
#include "flint_ends.h"
#include "mpoly_take.h"

/* A second or two. */
static const double MOST_STEPS = 1e9;

static bool standard(const struct poly_ideal *I, const ulong *exp, ulong *lead)
{
    for (int k = 0; k < I->count; k++) {
        bool divides = true;
        fmpz_mpoly_get_term_exp_ui(lead, I->g[k], 0, I->ctx);
        for (int v = 0; v < I->n; v++)
            divides = divides && lead[v] <= exp[v];
        if (divides)
            return false;
    }
    return true;
}

static int place_of(const struct hermite *h, const ulong *exp)
{
    for (int k = 0; k < h->count; k++)
        if (memcmp(h->monomial + (size_t)k * (size_t)h->I->n, exp, (size_t)h->I->n * sizeof *exp) == 0)
            return k;
    return -1;
}

/* A power of each variable alone is a leading monomial: the zeros are finitely many. */
bool hermite_finite(const struct poly_ideal *I)
{
    SGA_ARENA(mem);
    ulong *lead = sga_take(&mem, (size_t)I->n * sizeof *lead);
    for (int v = 0; v < I->n; v++) {
        bool alone = false;
        for (int k = 0; k < I->count && !alone; k++) {
            fmpz_mpoly_get_term_exp_ui(lead, I->g[k], 0, I->ctx);
            alone = true;
            for (int w = 0; w < I->n; w++)
                alone = alone && (w == v || lead[w] == 0);
        }
        if (!alone)
            return false;
    }
    return true;
}

/* From 1 on, by multiplication: each monomial below a standard one is standard. */
static bool find_monomials(struct hermite *h)
{
    int n = h->I->n;
    SGA_ARENA(mem);
    ulong *exp = sga_take(&mem, (size_t)n * sizeof *exp), *lead = sga_take(&mem, (size_t)n * sizeof *lead);
    h->monomial = sga_zeros(&h->mem, (size_t)HERMITE_MOST * (size_t)n, sizeof *h->monomial);
    h->from = sga_zeros(&h->mem, HERMITE_MOST, sizeof *h->from);
    h->by = sga_zeros(&h->mem, HERMITE_MOST, sizeof *h->by);
    h->count = standard(h->I, h->monomial, lead);
    for (int k = 0; k < h->count; k++)
        for (int v = 0; v < n; v++) {
            memcpy(exp, h->monomial + (size_t)k * (size_t)n, (size_t)n * sizeof *exp);
            exp[v]++;
            if (!standard(h->I, exp, lead) || place_of(h, exp) >= 0)
                continue;
            if (h->count == HERMITE_MOST)
                return false;
            h->from[h->count] = k;
            h->by[h->count] = v;
            memcpy(h->monomial + (size_t)h->count++ * (size_t)n, exp, (size_t)n * sizeof *exp);
        }
    return true;
}

static void end_matrix(fmpq_mat_struct *m)
{
    fmpq_mat_clear(m);
}

static fmpq_mat_struct *matrices(struct hermite *h, int count)
{
    fmpq_mat_struct *m = sga_take(&h->mem, ((size_t)count + 1) * sizeof *m);
    for (int k = 0; k < count; k++) {
        fmpq_mat_init(m + k, h->count, h->count);
        SGA_AT_END(&h->mem, end_matrix, m + k);
    }
    return m;
}

/* Column k of the matrix of variable v: x_v times the monomial k, reduced. */
static bool multiply(struct hermite *h, int v, int k)
{
    const struct poly_ideal *I = h->I;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *f = mpoly_take(&mem, I->ctx), *r = mpoly_take(&mem, I->ctx);
    ulong *exp = sga_take(&mem, (size_t)I->n * sizeof *exp);
    SGA_ENDS(fmpz_end) fmpz_t scale = { 0 };
    memcpy(exp, h->monomial + (size_t)k * (size_t)I->n, (size_t)I->n * sizeof *exp);
    exp[v]++;
    fmpz_mpoly_set_coeff_ui_ui(f, 1, exp, I->ctx);
    if (!poly_ideal_reduce(I, r, scale, f))
        return false;
    for (slong i = 0; i < r->length; i++) {
        fmpz_mpoly_get_term_exp_ui(exp, r, i, I->ctx);
        int place = place_of(h, exp);
        assert(place >= 0);            /* what is left of a division is standard */
        fmpq_set_fmpz_frac(fmpq_mat_entry(h->times + v, place, k), r->coeffs + i, scale);
    }
    return true;
}

static bool find_products(struct hermite *h)
{
    h->times = matrices(h, h->I->n);
    h->product = matrices(h, h->count);
    h->trace = sga_take(&h->mem, sizeof *h->trace);
    fmpq_mat_init(h->trace, 1, h->count);
    SGA_AT_END(&h->mem, end_matrix, h->trace);
    for (int v = 0; v < h->I->n; v++)
        for (int k = 0; k < h->count; k++)
            if (!multiply(h, v, k))
                return false;
    fmpq_mat_one(h->product);
    for (int j = 1; j < h->count; j++) {
        fmpq_mat_mul(h->product + j, h->times + h->by[j], h->product + h->from[j]);
        if (!sga_budget_ok(h->I->budget, NULL))
            return false;
    }
    for (int j = 0; j < h->count; j++)
        fmpq_mat_trace(fmpq_mat_entry(h->trace, 0, j), h->product + j);
    return true;
}

/* Entry (j, k): the trace of multiplication by the product of both monomials. */
static void fill_form(const struct hermite *h, fmpz_mat_t form)
{
    SGA_ENDS(fmpq_mat_end) fmpq_mat_t values, row;
    SGA_ENDS(fmpz_end) fmpz_t common = { 0 };
    fmpq_mat_init(values, h->count, h->count);
    fmpq_mat_init(row, 1, h->count);
    for (int j = 0; j < h->count; j++) {
        fmpq_mat_mul(row, h->trace, h->product + j);
        for (int k = 0; k < h->count; k++)
            fmpq_swap(fmpq_mat_entry(values, j, k), fmpq_mat_entry(row, 0, k));
    }
    fmpq_mat_get_fmpz_mat_matwise(form, common, values);
}

/* About how many steps a characteristic polynomial takes: so many primes, times the cube. */
static bool is_within_reach(const struct hermite *h, const fmpz_mat_t m)
{
    double n = h->count, bits = (double)FLINT_ABS(fmpz_mat_max_bits(m));
    return n * bits / 60 * n * n * n <= MOST_STEPS && sga_budget_ok(h->I->budget, NULL);
}

/* All eigenvalues are real: Descartes' rule of signs is exact for the characteristic polynomial. */
bool hermite_signature(const struct hermite *h, long *real, long *complex_zeros)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t p = { { 0 } };
    SGA_ENDS(fmpz_mat_end) fmpz_mat_t form;
    int last = 0, last_minus = 0;
    long above = 0, below = 0;
    fmpz_mat_init(form, h->count, h->count);
    fill_form(h, form);
    if (!is_within_reach(h, form))
        return false;
    fmpz_mat_charpoly(p, form);
    for (slong k = 0; k <= fmpz_poly_degree(p); k++) {
        int sign = fmpz_sgn(p->coeffs + k), minus = k % 2 ? -sign : sign;
        if (!sign)
            continue;
        above += last && sign != last;
        below += last_minus && minus != last_minus;
        last = sign;
        last_minus = minus;
    }
    *complex_zeros = above + below;
    *real = above - below;
    assert(above >= below && *complex_zeros <= h->count);
    return true;
}

bool hermite_find(struct hermite *h, const struct poly_ideal *I)
{
    *h = (struct hermite){ .I = I };
    return find_monomials(h) && find_products(h);
}

void hermite_clear(struct hermite *h)
{
    sga_arena_end(&h->mem);
}
