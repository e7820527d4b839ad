/* The noncommutative transfer matrix P^{-1} B as a Laurent series in s^{-1} (section 4).
 *
 * With U P = R in weak Popov form, row orders d_i: R = diag(s^{d_i}) T, where T = L + M_1 s^{-1} + ...
 * and L (leading row coefficients) is invertible; T^{-1} = X_0 + X_1 s^{-1} + ... follows from
 * L X_n = - sum over i >= 1, j + k = n - i of binom(-i, k) M_i X_j^(k), since
 * s^{-i} a = sum binom(-i, k) a^(k) s^{-i-k}. Then P^{-1} B = T^{-1} diag(s^{-d_i}) U B. */
#include "operator.h"

#include <stdlib.h>

#include "arena.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "popov.h"

/* binom(-i, k) for k >= 0 and any i */
static void binomial(fmpz_t c, int i, int k)
{
    if (i <= 0) {
        fmpz_bin_uiui(c, (ulong)-i, (ulong)k);
        return;
    }
    fmpz_bin_uiui(c, (ulong)(i + k - 1), (ulong)k);
    if (k % 2)
        fmpz_neg(c, c);
}

/* out[n0 + k] += binom(-i, k) a^(k), k = 0 .. as long as n0 + k < count: the terms of s^{-i} a */
static void shifted(fmpz_poly_q_struct **out, int n0, int count, const fmpz_poly_q_t a, int i)
{
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t d, p;
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    fmpz_poly_q_init(d);
    fmpz_poly_q_init(p);
    fmpz_poly_q_set(d, a);
    for (int k = 0; n0 + k < count && !fmpz_poly_q_is_zero(d); k++) {
        binomial(c, i, k);
        fmpz_poly_q_set(p, d);
        fmpz_poly_scalar_mul_fmpz(fmpz_poly_q_numref(p), fmpz_poly_q_numref(p), c);
        if (fmpz_poly_is_zero(fmpz_poly_q_numref(p)))
            fmpz_poly_one(fmpz_poly_q_denref(p));
        fmpz_poly_q_canonicalise(p);
        if (n0 + k >= 0)
            fmpz_poly_q_add(out[n0 + k], out[n0 + k], p);
        fmpz_poly_q_derivative(d, d);
    }
}

/* series[n] of count matrices: rows of m multiplied by s^{-d_i} from the left, where the term
 * a D^l of row i starts at place lead + d_i - l. */
static struct ratio_matrix *left_shift(const struct ore_matrix *m, const int *d, int lead, int count)
{
    struct ratio_matrix *series = sga_calloc((size_t)count + 1, sizeof *series);
    SGA_FREED fmpz_poly_q_struct **out = sga_malloc((size_t)(count + 1) * sizeof *out);
    for (int n = 0; n < count; n++)
        ratio_matrix_init(series + n, m->rows, m->cols);
    for (int i = 0; i < m->rows; i++)
        for (int j = 0; j < m->cols; j++) {
            for (int n = 0; n < count; n++)
                out[n] = ratio_at(series + n, i, j);
            for (int l = 0; l < ore_at(m, i, j)->len; l++)
                shifted(out, lead + d[i] - l, count, ore_at(m, i, j)->a + l, d[i]);
        }
    return series;
}

/* out[i + j + k] += binom(-i - shift, k) M_i X_j^(k): the product of M s^{-shift} and X */
static void series_mul(struct ratio_matrix *out, int count, const struct ratio_matrix *M, int from, int shift,
                       const struct ratio_matrix *X)
{
    SGA_ENDS(ratio_matrix_clear) struct ratio_matrix d = { 0 };
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    for (int j = 0; j < count; j++) {
        ratio_matrix_set(&d, X + j);
        for (int k = 0; j + k < count; k++) {
            for (int i = from; i + j + k < count; i++) {
                SGA_ENDS(ratio_matrix_clear) struct ratio_matrix p = { 0 };
                binomial(c, i + shift, k);
                ratio_matrix_init(&p, M[i].rows, d.cols);
                ratio_matrix_addmul(&p, M + i, &d);
                ratio_matrix_scale(&p, fmpz_get_si(c));
                ratio_matrix_add(out + i + j + k, &p);
            }
            ratio_matrix_derive(&d, &d);
        }
    }
}

/* X = T^{-1}, count terms */
static bool invert_series(struct ratio_matrix *X, const struct ratio_matrix *M, int count, const struct op_limits *limits,
                          struct sga_error *err)
{
    int n = M[0].rows;
    SGA_ENDS(ratio_matrix_clear) struct ratio_matrix one;
    ratio_matrix_init(&one, n, n);
    for (int i = 0; i < n; i++)
        fmpz_poly_q_one(ratio_at(&one, i, i));
    bool ok = ratio_matrix_solve(X, M, &one);
    for (int m = 1; m < count && ok; m++) {
        SGA_ENDS(ratio_matrix_clear) struct ratio_matrix sum, d = { 0 };
        SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
        ratio_matrix_init(&sum, n, n);
        for (int j = 0; j < m; j++) {
            ratio_matrix_set(&d, X + j);
            for (int k = 0; j + k < m; k++) {
                int i = m - j - k;
                SGA_ENDS(ratio_matrix_clear) struct ratio_matrix p;
                binomial(c, i, k);
                ratio_matrix_init(&p, n, n);
                ratio_matrix_addmul(&p, M + i, &d);
                ratio_matrix_scale(&p, -fmpz_get_si(c));
                ratio_matrix_add(&sum, &p);
                ratio_matrix_derive(&d, &d);
            }
        }
        ok = ratio_matrix_solve(X + m, M, &sum) && op_within(limits, NULL, err);
    }
    return ok;
}

static void clear_series(struct ratio_matrix *s, int count)
{
    for (int n = 0; n < count && s; n++)
        ratio_matrix_clear(s + n);
    free(s);
}

/* P times the series is B, as far as the terms go: place n of the product is s^{order - first - n}. */
static bool multiplies_out(const struct op_laurent *g, const struct op_system *s)
{
    int count = g->terms;
    struct ratio_matrix *M = sga_calloc((size_t)count + 1, sizeof *M), *out = sga_calloc((size_t)count + 1, sizeof *out);
    for (int n = 0; n < count; n++) {
        ratio_matrix_init(out + n, s->unknowns, s->sources);
        ratio_matrix_init(M + n, s->unknowns, s->unknowns);
        if (n <= s->order)
            ratio_matrix_set(M + n, s->A + s->order - n);
    }
    series_mul(out, count, M, 0, -s->order, g->coefficient);
    bool ok = true;
    for (int n = 0; n < count && ok; n++)
        ok = n == s->order - g->first ? ratio_matrix_equal(out + n, &s->B) : ratio_matrix_is_zero(out + n);
    clear_series(M, count);
    clear_series(out, count);
    return ok;
}

bool op_laurent_series(struct op_laurent *g, const struct op_system *s, const struct op_popov *weak, int bound,
                       int terms, const struct op_limits *limits, struct sga_error *err)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix W = { 0 };
    *g = (struct op_laurent){ 0 };
    op_right_side(&W, s, weak);
    int first = 0;                             /* the series may start at s^{-first} */
    bool any = false;
    for (int i = 0; i < W.rows; i++)
        for (int j = 0; j < W.cols; j++)
            if (!ore_is_zero(ore_at(&W, i, j)) && (!any || weak->order[i] - ore_order(ore_at(&W, i, j)) < first)) {
                first = weak->order[i] - ore_order(ore_at(&W, i, j));
                any = true;
            }
    if (!any)
        return true;
    terms = terms > s->order - bound + 1 ? terms : s->order - bound + 1;    /* so that B is among the products */
    int count = (bound > first ? bound - first : 0) + terms;
    struct ratio_matrix *M = left_shift(&weak->R, weak->order, 0, count);
    struct ratio_matrix *Y = left_shift(&W, weak->order, -first, count);
    struct ratio_matrix *X = sga_calloc((size_t)count + 1, sizeof *X), *out = sga_calloc((size_t)count + 1, sizeof *out);
    for (int n = 0; n < count; n++)
        ratio_matrix_init(out + n, s->unknowns, s->sources);
    bool ok = invert_series(X, M, count, limits, err);
    if (ok)
        series_mul(out, count, X, 0, 0, Y);
    int zero = 0;
    while (ok && zero < count && ratio_matrix_is_zero(out + zero))
        zero++;
    if (ok && zero == count)
        ok = sga_fail(err, SGA_E_WITNESS, "the transfer matrix has no term up to order %d, where its state form has one: "
                      "this is a bug", bound);
    if (ok) {
        g->first = first + zero;
        g->terms = count - zero < terms ? count - zero : terms;
        g->coefficient = sga_calloc((size_t)g->terms + 1, sizeof *g->coefficient);
        for (int n = 0; n < g->terms; n++)
            ratio_matrix_swap(g->coefficient + n, out + zero + n);
        if (!multiplies_out(g, s))
            ok = sga_fail(err, SGA_E_WITNESS, "the operator times its inverse series is not the identity: this is a bug");
    }
    clear_series(M, count);
    clear_series(Y, count);
    clear_series(X, count);
    clear_series(out, count);
    if (!ok)
        op_laurent_clear(g);
    return ok;
}

void op_laurent_clear(struct op_laurent *g)
{
    clear_series(g->coefficient, g->terms);
    *g = (struct op_laurent){ 0 };
}
