/* Eigenvalues and eigenvectors: they put the matrix together again, are orthonormal, and are the ones that were put in. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "lin_symmetric.h"

enum { MOST = 30 };

static double between(unsigned long *seed, double a, double b)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return a + (b - a) * (double)(*seed >> 11) * 0x1p-53;
}

static void one(unsigned long *seed)
{
    int n = 1 + (int)between(seed, 0, MOST);
    double A[MOST * MOST] = { 0 }, B[MOST * MOST], value[MOST], V[MOST * MOST], off = 0, skew = 0, trace = 0, sum = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++)
            A[i * n + j] = A[j * n + i] = between(seed, 0, 1) < 0.2 ? 0 : between(seed, -1, 1);
    memcpy(B, A, sizeof A);
    lin_symmetric(n, B, value, V);
    for (int i = 0; i < n; i++) {
        trace += A[i * n + i];
        sum += value[i];
        for (int j = 0; j < n; j++) {
            double a = -A[i * n + j], d = i == j ? -1 : 0;
            for (int k = 0; k < n; k++) {
                a += value[k] * V[k * n + i] * V[k * n + j];
                d += V[i * n + k] * V[j * n + k];
            }
            off = fmax(off, fabs(a));
            skew = fmax(skew, fabs(d));
        }
    }
    CHECK(off < 1e-13 * n && skew < 1e-13 * n && fabs(trace - sum) < 1e-13 * n, "n = %d: %g, %g", n, off, skew);
}

int main(void)
{
    unsigned long seed = check_seed(61);
    for (int turn = 0; turn < check_scale(200); turn++)
        one(&seed);
    double zero[4] = { 0 }, value[2], V[4], plane[4] = { 0, 2, 2, 0 };
    lin_symmetric(2, zero, value, V);
    CHECK(value[0] == 0 && value[1] == 0);
    lin_symmetric(2, plane, value, V);
    CHECK(fabs(value[0] * value[1] + 4) < 1e-14 && fabs(value[0] + value[1]) < 1e-14);
    return CHECK_END();
}
