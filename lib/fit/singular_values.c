/* Singular values by rotations of columns. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "least_squares.h"
#include "mem.h"

enum { SWEEPS = 60 };       /* a handful are needed */

/* Columns a, b of A and rows a, b of V turned so that the columns are orthogonal. Whether they were not. */
static bool rotate(double *A, int m, int p, double *V, int a, int b)
{
    double aa = 0, bb = 0, ab = 0;
    for (int i = 0; i < m; i++) {
        double x = A[(size_t)i * (size_t)p + (size_t)a], y = A[(size_t)i * (size_t)p + (size_t)b];
        aa += x * x;
        bb += y * y;
        ab += x * y;
    }
    if (!(fabs(ab) > DBL_EPSILON * sqrt(aa) * sqrt(bb)))
        return false;
    double zeta = (bb - aa) / (2 * ab), t = (zeta < 0 ? -1 : 1) / (fabs(zeta) + sqrt(1 + zeta * zeta)), c = 1 / sqrt(1 + t * t), s = c * t;
    for (int i = 0; i < m; i++) {
        double *x = A + (size_t)i * (size_t)p + (size_t)a, *y = A + (size_t)i * (size_t)p + (size_t)b, old = *x;
        *x = c * old - s * *y;
        *y = s * old + c * *y;
    }
    for (int j = 0; j < p; j++) {
        double *x = V + (size_t)a * (size_t)p + (size_t)j, *y = V + (size_t)b * (size_t)p + (size_t)j, old = *x;
        *x = c * old - s * *y;
        *y = s * old + c * *y;
    }
    return true;
}

static void exchange(double *A, int m, int p, double *s, double *V, int a, int b)
{
    double keep = s[a];
    s[a] = s[b];
    s[b] = keep;
    for (int i = 0; i < m; i++) {
        double *row = A + (size_t)i * (size_t)p;
        keep = row[a];
        row[a] = row[b];
        row[b] = keep;
    }
    for (int j = 0; j < p; j++) {
        double *x = V + (size_t)a * (size_t)p + (size_t)j, *y = V + (size_t)b * (size_t)p + (size_t)j;
        keep = *x;
        *x = *y;
        *y = keep;
    }
}

void fit_singular_values(double *A, int m, int p, double *s, double *V)
{
    for (int a = 0; a < p; a++)
        for (int b = 0; b < p; b++)
            V[(size_t)a * (size_t)p + (size_t)b] = a == b;
    bool turned = true;
    for (int k = 0; k < SWEEPS && turned; k++) {
        turned = false;
        for (int a = 0; a < p; a++)
            for (int b = a + 1; b < p; b++)
                turned |= rotate(A, m, p, V, a, b);
    }
    for (int a = 0; a < p; a++) {
        double sum = 0;
        for (int i = 0; i < m; i++)
            sum = hypot(sum, A[(size_t)i * (size_t)p + (size_t)a]);
        s[a] = sum;
        for (int i = 0; i < m && sum > 0; i++)
            A[(size_t)i * (size_t)p + (size_t)a] /= sum;
    }
    for (int a = 0; a < p; a++) {
        int most = a;
        for (int b = a + 1; b < p; b++)
            if (s[b] > s[most])
                most = b;
        if (most != a)
            exchange(A, m, p, s, V, a, most);
        assert(a == 0 || !(s[a - 1] < s[a]));
    }
}
