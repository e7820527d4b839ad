/* Natural sizes of the generators of a polynomial: powers of two s and h such that log2 |c| + e s is near h
 * for all terms c g^e, by least squares. Doubles then see 10^6 x^4 + 10^-6 y^4 as x^4 + y^4. */
#include "arena.h"
#include "gram.h"

#include <math.h>
#include <stdlib.h>

#include "mem.h"

enum { ALIKE = 4 /* bits that coefficients may differ by and nothing is done */, PLAIN = 12 /* and may be left as they are */, LARGEST = 400 /* bits of one monomial: products of two stay doubles */ };

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

/* The least squares problem: sizes of the generators, then the level of each polynomial. */
struct levels {
    struct gram *g;
    int n;
    double *N, *r, *row, least, most;
    ulong *exp;
};

/* All terms of f are near the level that is unknown number `own`. */
static void take_terms(struct levels *l, const fmpz_mpoly_t f, int own)
{
    const struct poly_bridge *b = l->g->b;
    for (slong t = 0; t < f->length; t++) {
        double bits = bits_of(f->coeffs + t);
        l->least = fmin(l->least, bits);
        l->most = fmax(l->most, bits);
        poly_exponents(b, f, t, l->exp);
        for (int i = 0; i < l->n; i++)
            l->row[i] = i >= b->gens ? -(i == own) : fixed(b->gen + i) ? 0 : (double)l->exp[i];
        for (int i = 0; i < l->n; i++) {
            l->r[i] -= l->row[i] * bits;
            for (int j = 0; j < l->n; j++)
                l->N[i * l->n + j] += l->row[i] * l->row[j];
        }
    }
}

void gram_sizes(struct gram *g, const fmpz_mpoly_t f, const fmpz_mpoly_struct *given, int count)
{
    static const double RIDGE = 1e-3;
    struct poly_bridge *b = g->b;
    int gens = b->gens, n = gens + 1 + count;
    SGA_ARENA(mem);
    struct levels l = { .g = g, .n = n, .least = INFINITY, .most = -INFINITY };
    slong degree = poly_degree(b, f);
    l.N = sga_zeros(&mem, (size_t)n * (size_t)(n + 2), sizeof *l.N);
    l.r = l.N + n * n;
    l.row = l.r + n;
    l.exp = sga_take(&mem, (size_t)b->max_gens * sizeof *l.exp);
    g->size = sga_calloc((size_t)gens + 1, sizeof *g->size);
    take_terms(&l, f, gens);
    g->scale = ldexp(1, (int)floor(l.most));
    for (int k = 0; k < count; k++) {
        take_terms(&l, given + k, gens + 1 + k);
        degree = poly_degree(b, given + k) > degree ? poly_degree(b, given + k) : degree;
    }
    if (l.most - l.least > ALIKE) {
        for (int i = 0; i < n; i++)
            l.N[i * n + i] += RIDGE;
        solve(l.N, l.r, n);
        double limit = LARGEST / fmax(1, (double)degree);
        for (int i = 0; i < gens; i++)
            g->size[i] = (int)nearbyint(fmax(-limit, fmin(limit, l.r[i])));
        g->scale = ldexp(1, (int)nearbyint(fmax(-LARGEST, fmin(LARGEST, l.r[gens]))));
    }
}

bool gram_sizes_forget(struct gram *g, const fmpz_mpoly_t f)
{
    bool any = false;
    double least = INFINITY, most = -INFINITY;
    for (int i = 0; i < g->b->gens; i++) {
        any |= g->size[i] != 0;
        g->size[i] = 0;
    }
    for (slong t = 0; t < f->length; t++) {
        least = fmin(least, bits_of(f->coeffs + t));
        most = fmax(most, bits_of(f->coeffs + t));
    }
    g->scale = ldexp(1, (int)floor(most));
    return any && most - least <= PLAIN;
}
