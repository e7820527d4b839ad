/* Natural sizes of the generators of a polynomial: powers of two s and h such that log2 |c| + e s is near h
 * for all terms c g^e, by least squares. Doubles then see 10^6 x^4 + 10^-6 y^4 as x^4 + y^4. */
#include "gram.h"

#include <math.h>
#include <stdlib.h>

#include "mem.h"

enum { ALIKE = 12 /* bits that coefficients may differ by and nothing is done */, LARGEST = 400 /* bits of one monomial: products of two stay doubles */ };

/* N x = r (n x n, positive definite, spent), x in r. */
static void solve(double *N, double *r, int n)
{
    for (int k = 0; k < n; k++)
        for (int i = k + 1; i < n; i++) {
            double f = N[i * n + k] / N[k * n + k];
            for (int j = k; j < n; j++)
                N[i * n + j] -= f * N[k * n + j];
            r[i] -= f * r[k];
        }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++)
            r[i] -= N[i * n + j] * r[j];
        r[i] /= N[i * n + i];
    }
}

static double bits_of(const fmpz_t c)
{
    slong exp;
    double d = fmpz_get_d_2exp(&exp, c);
    return log2(fabs(d)) + (double)exp;
}

/* Kernels with ranges keep their size 1: their weights have constants. */
static bool fixed(const struct poly_generator *q)
{
    return q->op == EXPR_SIN || q->op == EXPR_COS || q->op == EXPR_TANH || q->op == EXPR_COSH || q->op == EXPR_PI;
}

void gram_sizes(struct gram *g, const fmpz_mpoly_t f)
{
    static const double RIDGE = 1e-3;
    int gens = g->b->gens, n = gens + 1;
    double least = INFINITY, most = -INFINITY, *N = sga_calloc((size_t)n * (size_t)(n + 2), sizeof *N), *r = N + n * n, *row = r + n;
    ulong *exp = sga_malloc((size_t)g->b->max_gens * sizeof *exp);
    g->size = sga_calloc((size_t)n, sizeof *g->size);
    for (slong t = 0; t < f->length; t++) {
        double bits = bits_of(f->coeffs + t);
        least = fmin(least, bits);
        most = fmax(most, bits);
        poly_exponents(g->b, f, t, exp);
        for (int i = 0; i < gens; i++)
            row[i] = fixed(g->b->gen + i) ? 0 : (double)exp[i];
        row[gens] = -1;
        for (int i = 0; i < n; i++) {
            r[i] -= row[i] * bits;
            for (int j = 0; j < n; j++)
                N[i * n + j] += row[i] * row[j];
        }
    }
    g->scale = ldexp(1, (int)floor(most));
    if (most - least > ALIKE) {
        for (int i = 0; i < n; i++)
            N[i * n + i] += RIDGE;
        solve(N, r, n);
        double limit = LARGEST / fmax(1, (double)poly_degree(g->b, f));
        for (int i = 0; i < gens; i++)
            g->size[i] = (int)nearbyint(fmax(-limit, fmin(limit, r[i])));
        g->scale = ldexp(1, (int)nearbyint(fmax(-LARGEST, fmin(LARGEST, r[gens]))));
    }
    free(N);
    free(exp);
}
