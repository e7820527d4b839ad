/* Dense least-norm solutions: constructed rank, normal equations, orthogonality. */
#include "lin_dense.h"

#include <math.h>

#include "check.h"
#include "lin.h"

static unsigned long state;
static double uniform(void)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (double)(state >> 33) / (1ul << 30) - 1;
}

enum { MOST = 12 };

/* A = sum of `rank` random dyads; also a null vector's worth of test: x must be a
 * combination of the rows (the right factors), and A^T (A x - b) = 0. */
static void one(int m, int n, int rank)
{
    double left[MOST][MOST], right[MOST][MOST], a[MOST * MOST], b[MOST], x[MOST], y[MOST];
    for (int k = 0; k < rank; k++) {
        for (int i = 0; i < m; i++)
            left[k][i] = uniform();
        for (int j = 0; j < n; j++)
            right[k][j] = uniform();
    }
    for (int i = 0; i < m; i++) {
        b[i] = uniform();
        for (int j = 0; j < n; j++) {
            a[i * n + j] = 0;
            for (int k = 0; k < rank; k++)
                a[i * n + j] += left[k][i] * right[k][j];
        }
    }
    struct lin_dense A = {m, n, a};
    struct lin_least out;
    CHECK(lin_least_norm(&A, b, 1e-10, x, &out) && out.rank == rank, "%d x %d: rank %d of %d",
          m, n, out.rank, rank);
    double gradient = 0, sum = 0, res[MOST];
    for (int i = 0; i < m; i++) {
        res[i] = -b[i];
        for (int j = 0; j < n; j++)
            res[i] += a[i * n + j] * x[j];
        sum += res[i] * res[i];
    }
    for (int j = 0; j < n; j++) {
        double s = 0;
        for (int i = 0; i < m; i++)
            s += a[i * n + j] * res[i];
        gradient = fmax(gradient, fabs(s));
    }
    CHECK(gradient < 1e-12 * out.largest / out.smallest_kept, "%d x %d: %g", m, n, gradient);
    CHECK(fabs(out.residual - sqrt(sum)) < 1e-12);
    /* x is in the row space: solving sum c_k right_k = x leaves nothing */
    double rows[MOST * MOST];
    for (int j = 0; j < n; j++)
        for (int k = 0; k < rank; k++)
            rows[j * rank + k] = right[k][j];
    struct lin_dense R = {n, rank, rows};
    struct lin_least space;
    CHECK(lin_least_norm(&R, x, 1e-12, y, &space) && space.residual < 1e-11 * (1 + fabs(x[0])),
          "%d x %d: %g", m, n, space.residual);
}

static void test_edges(void)
{
    double a[] = {3, 4}, b[] = {10}, x[2], nan_[] = {1, NAN};
    struct lin_dense A = {1, 2, a}, none = {0, 2, NULL}, narrow = {1, 0, NULL}, bad = {1, 2, nan_};
    struct lin_least out;
    CHECK(lin_least_norm(&A, b, 0, x, &out));
    CHECK(fabs(x[0] - 1.2) < 1e-15 && fabs(x[1] - 1.6) < 1e-15 && out.residual < 1e-14);
    CHECK(lin_least_norm(&none, b, 0, x, &out) && x[0] == 0 && out.rank == 0 && out.residual == 0);
    CHECK(lin_least_norm(&narrow, b, 0, x, &out) && out.residual == 10);
    CHECK(!lin_least_norm(&bad, b, 0, x, &out) && x[0] == 0);
    double zero[] = {0, 0};
    struct lin_dense Z = {1, 2, zero};
    CHECK(lin_least_norm(&Z, b, 0, x, NULL) && x[0] == 0 && x[1] == 0);
}

int main(void)
{
    lin_init();
    state = check_seed(3);
    for (int run = 0; run < check_scale(60); run++) {
        int m = 1 + run % MOST, n = 1 + (run * 5) % MOST, least = m < n ? m : n;
        one(m, n, 1 + run % least);
    }
    test_edges();
    return CHECK_END();
}
