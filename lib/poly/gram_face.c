/* Facial reduction: where f has zeros every Gram matrix is singular, and the polynomials that
 * can be squared are those that vanish at the zeros. The kernel is seen in doubles and guessed to
 * be rational; a wrong guess leaves no Gram matrix, or none that is definite, and proves nothing. */
#include "gram.h"

#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"
#include "mpoly_take.h"

/* How many of the ascending eigenvalues are 0: below the widest gap among small ones. */
static int kernel_of(const double *value, int n)
{
    static const double SMALL = 1e-3, GAP = 20, NOTHING = 1e-14;
    double widest = GAP, top = n ? fmax(fabs(value[n - 1]), 1e-6) : 1;
    int kernel = n && fabs(value[n - 1]) < 1e-6 ? n : 0;
    for (int k = 0; k + 1 < n && value[k] < SMALL * top; k++) {
        double gap = fabs(value[k + 1]) / fmax(fabs(value[k]), NOTHING * top);
        if (gap > widest) {
            widest = gap;
            kernel = k + 1;
        }
    }
    return kernel;
}

/* Reduced echelon form of V (rows x n), the largest entry left as each pivot. pivot[r]: its column. */
static void echelon(double *V, int rows, int n, int *pivot)
{
    for (int r = 0; r < rows; r++) {
        int row = r, col = 0;
        for (int i = r; i < rows; i++)
            for (int j = 0; j < n; j++)
                if (fabs(V[i * n + j]) > fabs(V[row * n + col]) * (1 + 1e-6)) {
                    row = i;
                    col = j;
                }
        double d = V[row * n + col];
        for (int j = 0; j < n; j++) {
            double v = V[row * n + j];
            V[row * n + j] = V[r * n + j];
            V[r * n + j] = v / d;
        }
        for (int i = 0; i < rows; i++) {
            double f = V[i * n + col];
            for (int j = 0; j < n && i != r; j++)
                V[i * n + j] -= f * V[r * n + j];
        }
        pivot[r] = col;
    }
}

/* v as p/q with the least q; false: none within the tolerance. */
static bool rational(double v, double tolerance, int most, slong *p, slong *q)
{
    for (*q = 1; *q <= most && fabs(v) < 1e9; ++*q) {
        double x = v * (double)*q;
        if (fabs(x - nearbyint(x)) < tolerance * fmax(1, fabs(v)) * (double)*q) {
            *p = (slong)nearbyint(x);
            return true;
        }
    }
    return false;
}

/* out = q_c - sum over rows of V[r][c] q_pivot(r), times what makes it integral. */
static bool combine(struct poly_bridge *b, const struct gram_block *k, const double *V, int rows, const int *pivot, int c,
                    double tolerance, int most, fmpz_mpoly_t out)
{
    SGA_ARENA(mem);
    slong p, q, all = 1;
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_set(out, k->q + c, b->ctx);
    bool ok = true;
    for (int r = 0; r < rows && ok; r++) {
        ok = rational(V[r * k->count + c], tolerance, most, &p, &q) && all < WORD_MAX / (most + 1) / 1000000000;
        if (!ok || p == 0)
            continue;
        fmpz_mpoly_scalar_mul_si(out, out, q, b->ctx);
        fmpz_mpoly_scalar_mul_si(t, k->q + pivot[r], p, b->ctx);
        fmpz_mpoly_scalar_mul_si(t, t, all, b->ctx);
        fmpz_mpoly_sub(out, out, t, b->ctx);
        all *= q;
    }
    SGA_ENDS(fmpz_end) fmpz_t content = { 0 };
    poly_content(content, out);
    if (ok && !fmpz_is_zero(content))
        fmpz_mpoly_scalar_divexact_fmpz(out, out, content, b->ctx);
    return ok;
}

static bool in(const int *list, int n, int v)
{
    for (int i = 0; i < n; i++)
        if (list[i] == v)
            return true;
    return false;
}

/* In units of q itself: entry c of a kernel vector in doubles is that over 2^size(q_c). What is small before is 0. */
static void unscale(const struct gram *g, const struct gram_block *k, double *V, int rows, const int *pivot, double tolerance)
{
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < k->count; c++)
            V[r * k->count + c] = fabs(V[r * k->count + c]) < tolerance ? 0 : ldexp(V[r * k->count + c], gram_size_of(g, k->q + c) - gram_size_of(g, k->q + pivot[r]));
}

/* The block without its kernel (rows x count, spent); how many were lost, 0 where it is not rational. */
static int shorten(const struct gram *g, struct gram_block *k, double *V, int rows, double tolerance, int most)
{
    struct poly_bridge *b = g->b;
    int n = k->count, *pivot = sga_malloc((size_t)n * sizeof *pivot), kept = 0;
    fmpz_mpoly_struct *q = sga_malloc(((size_t)n + 1) * sizeof *q);
    bool ok = true;
    echelon(V, rows, n, pivot);
    unscale(g, k, V, rows, pivot, tolerance);
    for (int c = 0; c < n && ok; c++) {
        if (in(pivot, rows, c))
            continue;
        fmpz_mpoly_init(q + kept, b->ctx);
        ok = combine(b, k, V, rows, pivot, c, tolerance, most, q + kept++);
    }
    free(pivot);
    SGA_FREED fmpz_mpoly_struct *drop = ok ? k->q : q;
    int drops = ok ? n : kept;
    for (int i = 0; i < drops; i++)
        fmpz_mpoly_clear(drop + i, b->ctx);
    if (!ok)
        return 0;
    k->q = q;
    k->count = kept;
    return n - kept;
}

int gram_face(struct gram *g, const struct gram_parts *p, const double *y, double tolerance, int most)
{
    int lost = 0;
    for (int b = 0; b < g->blocks; b++) {
        int n = g->block[b].count;
        if (!n)
            continue;
        SGA_FREED double *Q = sga_malloc((2 * (size_t)n * (size_t)n + (size_t)n) * sizeof *Q);
        double *V = Q + n * n, *value = V + n * n;
        gram_matrix(p, y, b, Q);
        gram_eigen(Q, n, value, V);
        int kernel = kernel_of(value, n);
        for (int r = 0; r < kernel; r++)
            for (int i = 0; i < n; i++)
                Q[r * n + i] = V[i * n + r];
        lost += kernel ? shorten(g, g->block + b, Q, kernel, tolerance, most) : 0;
    }
    return lost;
}
