/* Least-norm solution by a pivoted QR of the transpose. */
#include "leastnorm.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

/* In four sums that do not wait for each other. */
static double dot(const double *a, const double *b, int n)
{
    double part[4] = { 0 };
    int i = 0;
    for (; i + 4 <= n; i += 4)
        for (int l = 0; l < 4; l++)
            part[l] += a[i + l] * b[i + l];
    for (; i < n; i++)
        part[0] += a[i] * b[i];
    return (part[0] + part[1]) + (part[2] + part[3]);
}

static double norm2(const double *v, int n)
{
    return dot(v, v, n);
}

/* v <- (I - beta h h^T) v from index k on; h is stored in row k of J from k on. False: v stays as it is. */
static bool reflect(const double *h, double beta, double *v, int k, int n)
{
    double s = beta * dot(h + k, v + k, n - k);
    if (s == 0)
        return false;
    for (int i = k; i < n; i++)
        v[i] -= s * h[i];
    return true;
}

int points_least_norm_factor(int c, int n, double *J, int *perm, double *work)
{
    double *beta = work, *R = work + c, first = 0;     /* of R what is above the diagonal, and that */
    int rank = 0;
    double *length = work;      /* squared, of what is left of the rows not taken yet: where their betas will be */
    for (int i = 0; i < c; i++) {
        perm[i] = i;
        length[i] = norm2(J + (size_t)i * (size_t)n, n);
    }
    /* row p of J is column p of J^T: Householder on rows */
    for (int k = 0; k < c && k < n; k++) {
        int best = k;
        for (int i = k + 1; i < c; i++)
            best = length[i] > length[best] ? i : best;
        double big = sqrt(length[best]);
        if (k == 0)
            first = big;
        if (!(big > 1e-13 * first) || !isfinite(big))
            break;
        int t = perm[k];
        perm[k] = perm[best];
        perm[best] = t;
        length[best] = length[k];
        double *h = J + (size_t)perm[k] * (size_t)n;
        for (int j = 0; j < k; j++)
            R[(size_t)j * (size_t)c + (size_t)k] = h[j];
        double alpha = h[k] > 0 ? -big : big;
        R[(size_t)k * (size_t)c + (size_t)k] = alpha;
        h[k] -= alpha;
        double hh = norm2(h + k, n - k);
        beta[k] = hh > 0 ? 2 / hh : 0;
        for (int i = k + 1; i < c; i++) {
            double *v = J + (size_t)perm[i] * (size_t)n;
            if (reflect(h, beta[k], v, k, n) || v[k] != 0)
                length[i] = norm2(v + k + 1, n - k - 1);
        }
        rank = k + 1;
    }
    return rank;
}

/* R^T z = -P^T r, then d = Q z. */
void points_least_norm_solve(int c, int n, const double *J, int rank, const int *perm, const double *work, const double *r, double *d)
{
    assert(rank >= 0 && rank <= c && rank <= n);
    const double *beta = work, *R = work + c;
    memset(d, 0, (size_t)n * sizeof *d);
    for (int k = 0; k < rank; k++)
        d[k] = -r[perm[k]];
    for (int j = 0; j < rank; j++) {
        const double *row = R + (size_t)j * (size_t)c;
        d[j] /= row[j];
        for (int k = j + 1; k < rank; k++)
            d[k] -= row[k] * d[j];
    }
    for (int k = rank - 1; k >= 0; k--)
        reflect(J + (size_t)perm[k] * (size_t)n, beta[k], d, k, n);
}

/* Q e_(rank + k). */
void points_least_norm_kernel(int n, const double *J, int rank, const int *perm, const double *work, int k, double *d)
{
    assert(rank + k >= 0 && rank + k < n);
    memset(d, 0, (size_t)n * sizeof *d);
    d[rank + k] = 1;
    for (int i = rank - 1; i >= 0; i--)
        reflect(J + (size_t)perm[i] * (size_t)n, work[i], d, i, n);
}

/* R P^T y = -Q^T v. */
void points_least_norm_multipliers(int c, int n, const double *J, int rank, const int *perm, const double *work, double *v, double *y)
{
    const double *R = work + c;
    for (int i = 0; i < rank; i++)
        reflect(J + (size_t)perm[i] * (size_t)n, work[i], v, i, n);
    memset(y, 0, (size_t)c * sizeof *y);
    for (int i = rank - 1; i >= 0; i--) {
        double sum = -v[i];
        for (int k = i + 1; k < rank; k++)
            sum -= R[(size_t)i * (size_t)c + (size_t)k] * y[perm[k]];
        y[perm[i]] = sum / R[(size_t)i * (size_t)c + (size_t)i];
    }
}

int points_least_norm(int c, int n, double *J, const double *r, double *d, int *perm, double *work)
{
    int rank = points_least_norm_factor(c, n, J, perm, work);
    points_least_norm_solve(c, n, J, rank, perm, work, r, d);
    assert(rank <= c && rank <= n);
    return rank;
}
