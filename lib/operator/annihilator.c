/* Krylov vectors of a torsion module: e and the c_i by one solve over Q(t). */
#include "annihilator.h"

#include <stdlib.h>

#include "arena.h"
#include "cyclic.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "popov.h"

/* The k-th combination to try for W with a 1 at m: sparse ones with small coefficients first. */
static void candidate(struct ratio_matrix *w, int m, int k)
{
    int r = w->cols;
    for (int i = 0; i < r; i++) {
        fmpz_poly_q_struct *to = ratio_at(w, 0, i);
        int h = (k * 31 + i * 7 + i * i * 3 * k) % 11;
        fmpz_poly_q_zero(to);
        if (i == m) {
            fmpz_poly_q_one(to);
            continue;
        }
        if (k == 0)
            continue;
        if (k <= 2 * r) {                      /* one more entry: 1 or t */
            if ((k - 1) / 2 == i)
                fmpz_poly_set_coeff_si(fmpz_poly_q_numref(to), (k - 1) % 2, 1);
            continue;
        }
        fmpz_poly_set_coeff_si(fmpz_poly_q_numref(to), h % 3 + (k > 4 * r ? i % (k / r) : 0), h - 5 ? h - 5 : 1);
    }
}

static bool find_cyclic(struct cyclic *c, const struct op_state *x, const struct op_limits *limits, struct sga_error *err)
{
    int r = x->H.rows;
    ratio_matrix_init(&c->w, 1, r);
    for (int k = 0; k < 12 * r + 12; k++)
        for (c->m = 0; c->m < r; c->m++) {
            candidate(&c->w, c->m, k);
            SGA_ENDS(ratio_matrix_clear) struct ratio_matrix row;
            ratio_matrix_init(&row, 1, x->n);
            ratio_matrix_addmul(&row, &c->w, &x->H);
            bool yes = op_is_cyclic(&x->F, &row);
            if (yes)
                return true;
            if (!op_within(limits, NULL, err))
                return false;
        }
    return sga_fail(err, SGA_E_UNDECIDED, "no cyclic vector was found among the combinations of the unknowns that were tried");
}

/* Size to expect: degrees of the n-th Krylov determinant. */
static bool affordable(const struct op_state *x, const struct op_limits *limits, struct sga_error *err)
{
    long degree = 0, bits = 1;
    for (int k = 0; k < x->n * x->n; k++) {
        const fmpz_poly_struct *p = fmpz_poly_q_numref(x->F.e + k), *q = fmpz_poly_q_denref(x->F.e + k);
        long d = fmpz_poly_degree(p) > fmpz_poly_degree(q) ? fmpz_poly_degree(p) : fmpz_poly_degree(q);
        long b = labs(fmpz_poly_max_bits(p)) > labs(fmpz_poly_max_bits(q)) ? labs(fmpz_poly_max_bits(p)) : labs(fmpz_poly_max_bits(q));
        degree = d > degree ? d : degree;
        bits = b > bits ? b : bits;
    }
    double steps = 0.5 * x->n * (x->n + 1), bytes = (steps * (double)degree + 1) * (steps * (double)bits + 64) / 8 * (x->n + 1);
    double most = limits->max_bytes ? (double)limits->max_bytes : 100.0 * (1 << 20);
    return bytes <= most || sga_fail(err, SGA_E_LIMIT_MEMORY, "the last invariant factor has order %d and would take about %.0f MB; "
                                     "the limit is %.0f MB", x->n, bytes / (1 << 20), most / (1 << 20));
}

/* e and the c_i, from the Krylov matrix K of w: rows w, Dw, .., z_i = sum c_il D^l w. */
static bool annihilate(struct cyclic *c, const struct op_state *x)
{
    int n = x->n, r = x->H.rows;
    SGA_ENDS(ratio_matrix_clear) struct ratio_matrix K, v, next = { 0 }, right, solution = { 0 };
    ratio_matrix_init(&K, n, n);               /* transposed: columns are w, Dw, ... */
    ratio_matrix_init(&right, n, r + 1);       /* columns: the unknowns, then D^n w */
    ratio_matrix_init(&v, 1, n);
    ratio_matrix_addmul(&v, &c->w, &x->H);
    for (int k = 0; k <= n; k++) {
        for (int j = 0; j < n; j++)
            fmpz_poly_q_set(k < n ? ratio_at(&K, j, k) : ratio_at(&right, j, r), ratio_at(&v, 0, j));
        ratio_matrix_derive(&next, &v);
        ratio_matrix_addmul(&next, &v, &x->F);
        ratio_matrix_swap(&v, &next);
    }
    for (int i = 0; i < r; i++)
        for (int j = 0; j < n; j++)
            fmpz_poly_q_set(ratio_at(&right, j, i), ratio_at(&x->H, i, j));
    bool ok = ratio_matrix_solve(&solution, &K, &right);
    if (ok) {                                  /* e w = 0, multiplied out */
        SGA_ENDS(ratio_matrix_clear) struct ratio_matrix sum;
        ratio_matrix_init(&sum, n, r + 1);
        ratio_matrix_addmul(&sum, &K, &solution);
        ok = ratio_matrix_equal(&sum, &right);
    }
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t a;
    fmpz_poly_q_init(a);
    for (int l = 0; l < n && ok; l++) {
        for (int i = 0; i < r; i++)
            ore_add_term(c->c + i, ratio_at(&solution, l, i), l);
        fmpz_poly_q_neg(a, ratio_at(&solution, l, r));
        ore_add_term(&c->e, a, l);
    }
    fmpz_poly_q_one(a);
    ore_add_term(&c->e, a, n);
    return ok;
}

bool op_annihilator_find(struct cyclic *c, const struct op_state *x, const struct op_limits *limits, struct sga_error *err)
{
    *c = (struct cyclic){ 0 };
    c->c = sga_calloc((size_t)x->H.rows + 1, sizeof *c->c);
    return affordable(x, limits, err) && find_cyclic(c, x, limits, err)
           && (annihilate(c, x) || sga_fail(err, SGA_E_WITNESS, "the annihilator of a cyclic vector was not found: this is a bug"));
}

void op_annihilator_clear(struct cyclic *c)
{
    for (int i = 0; i < c->w.cols; i++)
        ore_clear(c->c + i);
    free(c->c);
    ore_clear(&c->e);
    ratio_matrix_clear(&c->w);
    *c = (struct cyclic){ 0 };
}
