#include "dd_lu.h"

#include <math.h>

static void exchange(num_dd *a, int *perm, int m, int i, int j)
{
    int p = perm[i];
    perm[i] = perm[j];
    perm[j] = p;
    for (int c = 0; c < m; c++) {
        num_dd v = a[i * m + c];
        a[i * m + c] = a[j * m + c];
        a[j * m + c] = v;
    }
}

bool num_dd_lu_factor(num_dd *a, int *perm, int m)
{
    for (int i = 0; i < m; i++)
        perm[i] = i;
    for (int k = 0; k < m; k++) {
        int best = k;
        for (int i = k + 1; i < m; i++)
            if (fabs(a[i * m + k].hi) > fabs(a[best * m + k].hi))
                best = i;
        if (best != k)
            exchange(a, perm, m, k, best);
        if (a[k * m + k].hi == 0 || !isfinite(a[k * m + k].hi))
            return false;
        for (int i = k + 1; i < m; i++) {
            if (a[i * m + k].hi == 0)
                continue;
            num_dd f = a[i * m + k] = num_dd_div(a[i * m + k], a[k * m + k]);
            for (int c = k + 1; c < m; c++)
                a[i * m + c] = num_dd_sub(a[i * m + c], num_dd_mul(f, a[k * m + c]));
        }
    }
    return true;
}

void num_dd_lu_solve(const num_dd *lu, const int *perm, int m, const num_dd *b, num_dd *x)
{
    for (int i = 0; i < m; i++) {
        x[i] = b[perm[i]];
        for (int c = 0; c < i; c++)
            x[i] = num_dd_sub(x[i], num_dd_mul(lu[i * m + c], x[c]));
    }
    for (int i = m - 1; i >= 0; i--) {
        for (int c = i + 1; c < m; c++)
            x[i] = num_dd_sub(x[i], num_dd_mul(lu[i * m + c], x[c]));
        x[i] = num_dd_div(x[i], lu[i * m + i]);
    }
}
