/* Jacobi's method, cyclic by rows (Golub and Van Loan, Matrix Computations, 8.5). */
#include "lin_symmetric.h"

#include <math.h>
#include <string.h>

/* Sweeps converge quadratically: this many are never used up. */
enum { SWEEPS = 60 };

static void turn(double *a, double *b, double c, double s)
{
    double x = *a, y = *b;
    *a = c * x - s * y;
    *b = s * x + c * y;
}

/* The rotation that makes A_pq vanish. */
static void rotate(int n, double *A, double *V, int p, int q)
{
    double theta = (A[q * n + q] - A[p * n + p]) / (2 * A[p * n + q]);
    double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(1 + theta * theta)), c = 1 / sqrt(1 + t * t), s = t * c;
    for (int k = 0; k < n; k++)
        turn(A + k * n + p, A + k * n + q, c, s);
    for (int k = 0; k < n; k++)
        turn(A + p * n + k, A + q * n + k, c, s);
    for (int k = 0; k < n; k++)
        turn(V + p * n + k, V + q * n + k, c, s);
    A[p * n + q] = A[q * n + p] = 0;
}

void lin_symmetric(int n, double *A, double *value, double *V)
{
    memset(V, 0, (size_t)n * (size_t)n * sizeof *V);
    for (int k = 0; k < n; k++)
        V[k * n + k] = 1;
    double norm = 0;
    for (int k = 0; k < n * n; k++)
        norm = fmax(norm, fabs(A[k]));
    for (int sweep = 0, more = 1; sweep < SWEEPS && more; sweep++) {
        more = 0;
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++) {
                if (fabs(A[p * n + q]) > 1e-17 * norm) {
                    rotate(n, A, V, p, q);
                    more = 1;
                }
            }
    }
    for (int k = 0; k < n; k++)
        value[k] = A[k * n + k];
}
