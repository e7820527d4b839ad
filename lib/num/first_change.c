/* Intervals of (0, 1] are halved until the Bernstein coefficients show no change of sign or one; the left half comes first. */
#include "first_change.h"

#include <assert.h>
#include <math.h>

enum { DEPTH = 64, INTERVALS = 400 };
static const double NOISE = 1e-15;       /* of the sizes that a coefficient was summed from */
static const double LEAST = 1e-11;

/* The Bernstein coefficients of p on (a, b) into e, the sums of the sizes that they came from into size. */
static void bernstein(const double *c, int k, double a, double b, double *e, double *size)
{
    for (int q = 0; q <= k; q++) {
        e[q] = c[q];
        size[q] = fabs(c[q]);
    }
    if (a > 0)
        for (int r = 0; r < k; r++)
            for (int q = k - 1; q >= r; q--) {
                e[q] += a * e[q + 1];
                size[q] += a * size[q + 1];
            }
    double scale = 1;
    for (int q = 1; q <= k; q++) {
        scale *= (b - a) * q / (k - q + 1);        /* (b - a)^q over the binomial k, q */
        e[q] *= scale;
        size[q] *= scale;
    }
    for (int r = 1; r <= k; r++)
        for (int q = k; q >= r; q--) {
            e[q] += e[q - 1];
            size[q] += size[q - 1];
        }
}

static int variations(const double *e, const double *size, int k)
{
    int count = 0;
    bool above = true;
    for (int q = 1; q <= k; q++)
        if (above ? e[q] < -NOISE * size[q] : e[q] > NOISE * size[q]) {
            above = !above;
            count++;
        }
    return count;
}

bool num_first_change(const double *c, int k, double *work, double *low, double *high)
{
    assert(k >= 0);
    double from[DEPTH] = { 0 }, to[DEPTH] = { 1 };
    for (int q = 0; q <= k; q++)
        if (!isfinite(c[q]))
            return false;
    int left = 1;
    for (int open = 1, count = 0; open && count < INTERVALS; count++) {
        left = open - 1;
        double a = from[--open], b = to[open], middle = 0.5 * (a + b), *size = work + k + 1;
        bernstein(c, k, a, b, work, size);
        int changes = variations(work, size, k);
        bool beyond = work[k] < -NOISE * size[k];
        *low = a;
        *high = b;
        if (changes == 1 || (beyond && b - a < LEAST))
            return true;
        if (!changes || b - a < LEAST)
            continue;
        if (open + 2 > DEPTH)
            return beyond;
        from[open] = middle;
        to[open++] = b;
        from[open] = a;
        to[open++] = middle;
        left = open;
    }
    if (left)       /* too many near zeros to tell apart: a change in all of it, if there is one at its end */
        bernstein(c, k, *low = 0, *high = 1, work, work + k + 1);
    return left && work[k] < -NOISE * work[2 * k + 1];
}
