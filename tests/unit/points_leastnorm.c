/* Steps of least norm: the rows hold, the step is a combination of them, the rank is that of the construction; and factors
 * that are kept give for each right side what a new factorisation gives, to the bit. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "check.h"
#include "leastnorm.h"

enum { MOST = 24 };

static double between(uint64_t *seed, double a, double b)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return a + (b - a) * (double)(*seed >> 11) * 0x1p-53;
}

/* J of rank r as a product of random factors; right sides that can be met are J times something. */
static void make(uint64_t *seed, int c, int n, int r, double *J)
{
    double left[MOST * MOST], right[MOST * MOST];
    for (int i = 0; i < MOST * MOST; i++) {
        left[i] = between(seed, -1, 1);
        right[i] = between(seed, -1, 1);
    }
    for (int i = 0; i < c; i++)
        for (int j = 0; j < n; j++) {
            J[i * n + j] = 0;
            for (int k = 0; k < r; k++)
                J[i * n + j] += left[i * MOST + k] * right[k * MOST + j];
        }
}

static double product(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += a[j] * b[j];
    return sum;
}

/* v = what the rows make of it + what they map to 0, by the multipliers and by the vectors of the kernel. */
static void kernel(int c, int n, const double *J, const double *kept, int rank, const int *perm, const double *work, const double *v)
{
    double left[MOST], y[MOST], again[MOST], d[MOST], off = 0;
    memcpy(again, v, (size_t)n * sizeof *v);
    memcpy(left, v, (size_t)n * sizeof *v);
    points_least_norm_multipliers(c, n, kept, rank, perm, work, again, y);
    for (int i = 0; i < c; i++)
        for (int j = 0; j < n; j++)
            left[j] += y[i] * J[i * n + j];
    for (int k = 0; k < n - rank; k++) {
        points_least_norm_kernel(n, kept, rank, perm, work, k, d);
        for (int i = 0; i < c; i++)
            off = fmax(off, fabs(product(J + i * n, d, n)));
        double part = product(left, d, n);
        CHECK(fabs(product(d, d, n) - 1) < 1e-12, "length");
        for (int j = 0; j < n; j++)
            left[j] -= part * d[j];
    }
    CHECK(off < 1e-10 && product(left, left, n) < 1e-16 * (1 + product(v, v, n)), "the kernel misses by %g, the sum by %g", off, product(left, left, n));
}

static void one(uint64_t *seed)
{
    int c = 1 + (int)between(seed, 0, MOST), n = 1 + (int)between(seed, 0, MOST), least = c < n ? c : n;
    int r = 1 + (int)between(seed, 0, least), perm[MOST], again[MOST];
    double J[MOST * MOST], kept[MOST * MOST], other[MOST * MOST], work[MOST + MOST * MOST], new[MOST + MOST * MOST];
    make(seed, c, n, r, J);
    memcpy(kept, J, sizeof J);
    int rank = points_least_norm_factor(c, n, kept, perm, work);
    CHECK(rank == r, "%d of %d x %d, not %d", rank, c, n, r);
    for (int turn = 0; turn < 3; turn++) {
        double to[MOST], rhs[MOST], d[MOST], e[MOST], miss = 0, along = 0, size = 0;
        for (int j = 0; j < n; j++)
            to[j] = between(seed, -1, 1);
        for (int i = 0; i < c; i++) {
            rhs[i] = 0;
            for (int j = 0; j < n; j++)
                rhs[i] -= J[i * n + j] * to[j];
        }
        points_least_norm_solve(c, n, kept, rank, perm, work, rhs, d);
        memcpy(other, J, sizeof J);
        CHECK(points_least_norm(c, n, other, rhs, e, again, new) == rank && !memcmp(d, e, (size_t)n * sizeof *d));
        for (int i = 0; i < c; i++) {
            double s = rhs[i];
            for (int j = 0; j < n; j++)
                s += J[i * n + j] * d[j];
            miss = fmax(miss, fabs(s));
        }
        /* J (to - d) = 0, so that of least norm is orthogonal to it */
        for (int j = 0; j < n; j++) {
            along += (to[j] - d[j]) * d[j];
            size += to[j] * to[j];
        }
        kernel(c, n, J, kept, rank, perm, work, to);
        CHECK(miss < 1e-8 * (1 + size) && fabs(along) < 1e-6 * (1 + size), "misses by %g, along the kernel %g", miss, along);
    }
}

int main(void)
{
    uint64_t seed = check_seed(51);
    for (int turn = 0; turn < check_scale(400); turn++)
        one(&seed);
    return CHECK_END();
}
