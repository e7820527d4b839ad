/* Dense LU with partial pivoting (Golub & Van Loan, algorithm 3.4.1, by rows). */
#include "lu.h"

#include <assert.h>
#include <math.h>

static void swap_rows(double *a, int *perm, int m, int i, int j)
{
    for (int k = 0; k < m; k++) {
        double t = a[i * m + k];
        a[i * m + k] = a[j * m + k];
        a[j * m + k] = t;
    }
    int t = perm[i];
    perm[i] = perm[j];
    perm[j] = t;
}

/* Each row once. */
static bool is_permutation(const int *perm, int m)
{
    long sum = 0, squares = 0;
    for (int i = 0; i < m; i++) {
        sum += perm[i] - i;
        squares += (long)perm[i] * perm[i] - (long)i * i;
    }
    return sum == 0 && squares == 0;
}

bool num_lu_factor(double *a, int *perm, int m)
{
    for (int i = 0; i < m; i++)
        perm[i] = i;
    for (int k = 0; k < m; k++) {
        int best = k;
        for (int i = k + 1; i < m; i++)
            if (fabs(a[i * m + k]) > fabs(a[best * m + k]))
                best = i;
        double pivot = a[best * m + k];
        if (pivot == 0 || !isfinite(pivot))
            return false;
        if (best != k)
            swap_rows(a, perm, m, k, best);
        const double *u = a + k * m;
        for (int i = k + 1; i < m; i++) {
            double *row = a + i * m, l = row[k] / pivot;
            row[k] = l;
            if (l == 0)
                continue;
            for (int j = k + 1; j < m; j++)
                row[j] -= l * u[j];
        }
    }
    assert(is_permutation(perm, m));
    return true;
}

void num_lu_solve(const double *lu, const int *perm, int m, const double *b, double *x)
{
    for (int i = 0; i < m; i++) {
        double s = b[perm[i]];
        for (int j = 0; j < i; j++)
            s -= lu[i * m + j] * x[j];
        x[i] = s;
    }
    for (int i = m - 1; i >= 0; i--) {
        double s = x[i];
        for (int j = i + 1; j < m; j++)
            s -= lu[i * m + j] * x[j];
        x[i] = s / lu[i * m + i];
    }
}

void num_lu_solve_transposed(const double *lu, const int *perm, int m, double *b, double *x)
{
    for (int i = 0; i < m; i++) {
        b[i] /= lu[i * m + i];
        for (int j = i + 1; j < m; j++)
            b[j] -= lu[i * m + j] * b[i];
    }
    for (int i = m - 1; i > 0; i--)
        for (int j = 0; j < i; j++)
            b[j] -= lu[i * m + j] * b[i];
    for (int i = 0; i < m; i++)
        x[perm[i]] = b[i];
}
