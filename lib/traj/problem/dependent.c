/* Gauss with all pivots searched: see dependent.h. */
#include "dependent.h"

#include <math.h>
#include <string.h>

#include "arena.h"
#include "mem.h"

/* Rows that depend on others, and what these miss, by their size. */
static const double DEPENDS = 1e-11, MET = 1e-9;

bool dependent_solve(double *K, double *b, double *z, int size, double speed)
{
    SGA_FREED int *order = sga_calloc((size_t)size + 1, sizeof *order);
    size_t n = (size_t)size;
    double most = 0, ask = speed;
    int rank = 0;
    for (size_t i = 0; i < n; i++) {
        double row = 0;
        for (size_t k = 0; k < n; k++)
            row = fmax(row, fabs(K[i * n + k]));
        for (size_t k = 0; k < n && row > 0; k++)
            K[i * n + k] /= row;
        b[i] = row > 0 ? b[i] / row : b[i];
        ask = fmax(ask, fabs(b[i]));
        order[i] = (int)i;
    }
    for (; rank < size; rank++) {
        size_t r = (size_t)rank, pi = r, pk = r;
        for (size_t i = r; i < n; i++)
            for (size_t k = r; k < n; k++)
                if (fabs(K[i * n + k]) > fabs(K[pi * n + pk])) {
                    pi = i;
                    pk = k;
                }
        double pivot = fabs(K[pi * n + pk]);
        most = fmax(most, pivot);
        if (pivot <= DEPENDS * most || pivot == 0)
            break;
        for (size_t k = 0; k < n && pi != r; k++) {
            double keep = K[r * n + k];
            K[r * n + k] = K[pi * n + k];
            K[pi * n + k] = keep;
        }
        double keep = b[r];
        b[r] = b[pi];
        b[pi] = keep;
        for (size_t i = 0; i < n && pk != r; i++) {
            double held = K[i * n + r];
            K[i * n + r] = K[i * n + pk];
            K[i * n + pk] = held;
        }
        int o = order[r];
        order[r] = order[pk];
        order[pk] = o;
        for (size_t i = r + 1; i < n; i++) {
            double f = K[i * n + r] / K[r * n + r];
            for (size_t k = r; k < n && f != 0; k++)
                K[i * n + k] -= f * K[r * n + k];
            b[i] -= f * b[r];
        }
    }
    for (size_t i = (size_t)rank; i < n; i++)
        if (fabs(b[i]) > MET * ask)
            return false;
    memset(z, 0, n * sizeof *z);
    for (int i = rank - 1; i >= 0; i--) {
        size_t r = (size_t)i;
        double sum = b[r];
        for (size_t k = r + 1; k < (size_t)rank; k++)
            sum -= K[r * n + k] * z[order[k]];
        z[order[r]] = sum / K[r * n + r];
    }
    return true;
}
