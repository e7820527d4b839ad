/* Shifted systems: residuals of solutions, dense and sparse ways against each other, the
 * sign of the determinant, singular and unusual input. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "lin_shift.h"
#include "lin_sparse.h"
#include "mem.h"

static unsigned long state;
static double uniform(void)
{
    state = state * 6364136223846793005UL + 1442695040888963407UL;
    return (double)(state >> 11) / 9007199254740992.0;
}

/* A band of the given width with some entries missing, the diagonal not always there. */
static struct lin_sparse *random_matrix(int n, int width)
{
    int *ptr = sga_calloc((size_t)n + 1, sizeof *ptr), *col = sga_malloc((size_t)n * (size_t)n * sizeof *col);
    for (int i = 0; i < n; i++) {
        ptr[i + 1] = ptr[i];
        for (int j = 0; j < n; j++)
            if (abs(i - j) <= width && uniform() < 0.8)
                col[ptr[i + 1]++] = j;
    }
    struct lin_sparse *a = lin_sparse_new(n, n, ptr, col);
    for (int k = 0; k < ptr[n]; k++)
        a->val[k] = 2 * uniform() - 1;
    free(ptr);
    free(col);
    return a;
}

/* |(sigma I - J) x - b| over the size of its terms */
static double residual(const struct lin_sparse *J, double re, double im, const double *x, const double *b)
{
    double worst = 0;
    for (int i = 0; i < J->rows; i++) {
        double u = re * x[2 * i] - im * x[2 * i + 1] - b[2 * i], v = re * x[2 * i + 1] + im * x[2 * i] - b[2 * i + 1];
        double size = 1;
        for (int k = J->ptr[i]; k < J->ptr[i + 1]; k++) {
            u -= J->val[k] * x[2 * J->col[k]];
            v -= J->val[k] * x[2 * J->col[k] + 1];
            size += fabs(J->val[k]) * (fabs(x[2 * J->col[k]]) + fabs(x[2 * J->col[k] + 1]));
        }
        worst = fmax(worst, (fabs(u) + fabs(v)) / size);
    }
    return worst;
}

static void test_solve(int n, int width)
{
    struct lin_sparse *J = random_matrix(n, width);
    struct lin_shift *s = lin_shift_new(J);
    double *b = sga_malloc(2 * (size_t)n * sizeof *b), *x = sga_malloc(2 * (size_t)n * sizeof *x);
    for (int turn = 0; turn < 4; turn++) {     /* the later ones with old pivots */
        for (int k = 0; k < LIN_SHIFTS; k++) {
            double re = 3 * uniform(), im = k ? 3 * uniform() : 0;
            for (int i = 0; i < 2 * n; i++)
                x[i] = b[i] = k || i % 2 == 0 ? uniform() - 0.5 : 0;
            CHECK(lin_shift_factor(s, k, re, im, J->val));
            if (k == 0) {
                for (int i = 0; i < n; i++)
                    x[i] = b[2 * i];
                lin_shift_solve(s, 0, x);
                for (int i = n - 1; i >= 0; i--) {
                    x[2 * i] = x[i];
                    x[2 * i + 1] = 0;
                }
            } else {
                lin_shift_solve(s, k, x);
            }
            double r = residual(J, re, im, x, b);
            CHECK(r < 1e-11, "n %d, shift %d: %g", n, k, r);
        }
        for (int k = 0; k < J->ptr[n]; k++)
            J->val[k] *= 0.5 + uniform();
    }
    CHECK(lin_shift_cost(s) > 0 && lin_shift_solve_cost(s) > 0);
    free(b);
    free(x);
    lin_shift_free(s);
    lin_sparse_free(J);
}

/* J = S diag(1, .., n) S^-1 with S bidiagonal: eigenvalues 1 .. n; below k of them the
 * determinant's sign is (-1)^(n-k). Given as a full lower triangle plus a permutation. */
static void test_sign(int n)
{
    int *ptr = sga_calloc((size_t)n + 1, sizeof *ptr), *col = sga_malloc(3 * (size_t)n * sizeof *col);
    double *val = sga_malloc(3 * (size_t)n * sizeof *val);
    for (int i = 0; i < n; i++) {
        int *p = &ptr[i + 1];
        *p = ptr[i];
        if (i > 1) {
            col[*p] = i - 2;
            val[(*p)++] = uniform() * 10;
        }
        col[*p] = i;
        val[(*p)++] = i + 1;
    }
    struct lin_sparse *J = lin_sparse_new(n, n, ptr, col);
    struct lin_shift *s = lin_shift_new(J);
    for (int k = n; k >= 0 && k > n - 6; k--) {
        CHECK(lin_shift_factor(s, 0, k + 0.5, 0, val));
        CHECK(lin_shift_sign(s) == ((n - k) % 2 ? -1 : 1), "n %d, %d above", n, n - k);
    }
    CHECK(!lin_shift_factor(s, 0, NAN, 0, val));
    CHECK(!lin_shift_factor(s, 0, 1, 0, val), "singular");
    CHECK(lin_shift_factor(s, 0, 0.5, 0, val), "and regular again");
    lin_shift_free(s);
    lin_sparse_free(J);
    free(ptr);
    free(col);
    free(val);
}

int main(void)
{
    state = check_seed(4711);
    int sizes[] = {1, 2, 3, 10, 29, 31, 80, 300};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        test_solve(sizes[i], 2);
        test_solve(sizes[i], sizes[i] > 100 ? 6 : sizes[i]);
        test_sign(sizes[i]);
    }
    lin_shift_free(NULL);
    return CHECK_END();
}
