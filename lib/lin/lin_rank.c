/* How many singular values are above a bound: two-sided Householder reflections to bidiagonal form (Golub and Kahan 1965), and Sturm's
 * count for its symmetric form of twice the order with a diagonal of zeros, which finds the least ones to full relative accuracy
 * (Demmel and Kahan 1990). No vectors, so that it costs a tenth of what they do. */
#include "lin_rank.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "arena.h"
#include "lin_sparse.h"

/* The rows from k on of a matrix of p x q by rows, and the bidiagonal that comes of it. */
struct bidiagonal {
    int p, q;               /* p >= q */
    double *a, *sum;        /* sum: q */
    double *side;           /* 2 q - 1: diagonal and what is beside it, in turn; by columns of the form of twice the order */
};

/* What takes v (size) to a multiple of the first axis: v becomes the direction, *beta its factor; returns the multiple. Unchanged where it is one already. */
static double direction(double *v, int size, double *beta)
{
    double sum = 0;
    *beta = 0;
    for (int i = 1; i < size; i++)
        sum += v[i] * v[i];
    if (size < 1 || !(sum > 0))
        return size < 1 ? 0 : v[0];
    double len = sqrt(sum + v[0] * v[0]), to = v[0] > 0 ? -len : len;
    v[0] -= to;
    *beta = 2 / (sum + v[0] * v[0]);
    return to;
}

/* Column k below the diagonal to 0, by rows: the sum of all rows that the reflection takes from each. */
static void column(struct bidiagonal *b, int k, double *v)
{
    int q = b->q;
    double beta;
    for (int i = k; i < b->p; i++)
        v[i - k] = b->a[(size_t)i * (size_t)q + (size_t)k];
    b->side[2 * k] = direction(v, b->p - k, &beta);
    if (beta == 0)
        return;
    memset(b->sum, 0, (size_t)q * sizeof *b->sum);
    for (int i = k; i < b->p; i++) {
        const double *row = b->a + (size_t)i * (size_t)q;
        double by = v[i - k];
        for (int j = k + 1; j < q && by != 0; j++)
            b->sum[j] += by * row[j];
    }
    for (int i = k; i < b->p; i++) {
        double *row = b->a + (size_t)i * (size_t)q, by = beta * v[i - k];
        for (int j = k + 1; j < q && by != 0; j++)
            row[j] -= by * b->sum[j];
    }
}

/* Row k right of the first beside the diagonal to 0. */
static void row(struct bidiagonal *b, int k)
{
    int q = b->q, size = q - k - 1;
    double *v = b->a + (size_t)k * (size_t)q + k + 1, beta;
    if (size < 1)
        return;
    b->side[2 * k + 1] = direction(v, size, &beta);
    for (int i = k + 1; i < b->p && beta != 0; i++) {
        double *other = b->a + (size_t)i * (size_t)q + k + 1, sum = 0;
        for (int j = 0; j < size; j++)
            sum += v[j] * other[j];
        sum *= beta;
        for (int j = 0; j < size && sum != 0; j++)
            other[j] -= sum * v[j];
    }
}

/* Eigenvalues of the form above x > 0: of each pair of them that is not 0, one is positive, the singular value. */
static int above(const double *side, int count, double x)
{
    double least = DBL_MIN, pivot = -x;
    int positive = 0;
    for (int i = 0; i < count; i++) {
        if (fabs(pivot) < least)
            pivot = -least;
        pivot = -x - side[i] * (side[i] / pivot);
        positive += pivot > 0;
    }
    return positive;
}

/* The largest singular value, between those of an entry and of all of them. */
static double largest(const double *side, int count)
{
    double low = 0, high = 0;
    for (int i = 0; i < count; i++) {
        low = fmax(low, fabs(side[i]));
        high = fmax(high, fabs(side[i]) + (i ? fabs(side[i - 1]) : 0));
    }
    for (int k = 0; k < 60 && high > low * (1 + 4 * DBL_EPSILON); k++) {
        double middle = low + (high - low) / 2;
        *(above(side, count, middle) ? &low : &high) = middle;
    }
    return high;
}

bool lin_rank(const struct lin_dense *A, double rtol, double least, double *bound, int *rank)
{
    assert(rtol >= 0 && least >= 0 && *bound >= 0);
    bool wide = A->cols > A->rows;
    int p = wide ? A->cols : A->rows, q = wide ? A->rows : A->cols;
    double most = 0;
    *rank = 0;
    if (!lin_all_finite(A->rows * A->cols, A->a))
        return false;
    for (int i = 0; i < A->rows * A->cols; i++)
        most = fmax(most, fabs(A->a[i]));
    SGA_ARENA(mem);
    struct bidiagonal b = { p, q, sga_zeros(&mem, (size_t)p * (size_t)q + 1, sizeof(double)), sga_zeros(&mem, (size_t)q + 1, sizeof(double)),
                            sga_zeros(&mem, 2 * (size_t)q + 1, sizeof(double)) };
    double *v = sga_take(&mem, ((size_t)p + 1) * sizeof *v);
    int unit;
    frexp(most, &unit);          /* squares neither overflow nor vanish */
    for (int i = 0; i < A->rows; i++)
        for (int j = 0; j < A->cols; j++)
            b.a[wide ? (size_t)j * (size_t)q + (size_t)i : (size_t)i * (size_t)q + (size_t)j]
                = ldexp(A->a[(size_t)i * (size_t)A->cols + (size_t)j], -unit);
    for (int k = 0; k < q && most > 0; k++) {
        column(&b, k, v);
        row(&b, k);
    }
    int count = q ? 2 * q - 1 : 0;
    if (*bound == 0)
        *bound = rtol * fmax(most > 0 ? ldexp(largest(b.side, count), unit) : 0, least);
    if (most > 0)
        *rank = above(b.side, count, fmax(ldexp(*bound, -unit), DBL_MIN));
    assert(*rank <= q);
    return true;
}
