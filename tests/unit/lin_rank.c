/* Ranks without vectors: of constructed singular values, and beside those that GSL's vectors come with. */
#include "lin_rank.h"

#include <math.h>

#include "check.h"
#include "lin.h"

static unsigned long state;
static double uniform(void)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (double)(state >> 33) / (1ul << 30) - 1;
}

enum { MOST = 40 };

/* a (m x n) reflected at a random plane, from the left. */
static void reflect(double *a, int m, int n)
{
    double v[MOST], len = 0;
    for (int i = 0; i < m; i++) {
        v[i] = uniform();
        len += v[i] * v[i];
    }
    for (int j = 0; j < n; j++) {
        double sum = 0;
        for (int i = 0; i < m; i++)
            sum += v[i] * a[i * n + j];
        for (int i = 0; i < m; i++)
            a[i * n + j] -= 2 * sum / len * v[i];
    }
}

static void transpose(const double *a, int m, int n, double *to)
{
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++)
            to[j * m + i] = a[i * n + j];
}

/* Singular values unit * ratio^-k, `zeros` of them 0, in an m x n matrix without zeros: told apart as far as doubles reach. */
static void test_constructed(int m, int n, int zeros, double ratio, double unit)
{
    static double a[MOST * MOST], b[MOST * MOST];
    int least = m < n ? m : n, rank;
    for (int i = 0; i < m * n; i++)
        a[i] = 0;
    for (int k = 0; k < least - zeros; k++)
        a[k * n + k] = unit * pow(ratio, -k);
    for (int k = 0; k < 3; k++) {
        reflect(a, m, n);
        transpose(a, m, n, b);
        reflect(b, n, m);
        transpose(b, n, m, a);
    }
    struct lin_dense A = { m, n, a };
    for (int k = 0; k < least - zeros && pow(ratio, -k) > 1e-12; k++) {
        double bound = 0, rtol = pow(ratio, -k - 0.5);
        CHECK(lin_rank(&A, rtol, 0, &bound, &rank) && rank == k + 1, "%d x %d, ratio %g, unit %g: %d, not %d", m, n, ratio, unit, rank, k + 1);
        CHECK(fabs(bound - rtol * unit) < 1e-13 * rtol * unit, "the largest of %d x %d: %g, not %g", m, n, bound / rtol, unit);
        bound = unit * rtol;
        CHECK(lin_rank(&A, 0, 0, &bound, &rank) && rank == k + 1);
    }
    double bound = 0;
    CHECK(lin_rank(&A, 0.5, 8 * unit, &bound, &rank) && rank == 0 && bound == 4 * unit);
    bound = 0;
    if (pow(ratio, -least) > 1e-12)
        CHECK(lin_rank(&A, 1e-13, 0, &bound, &rank) && rank == least - zeros, "%d x %d: %d, not %d", m, n, rank, least - zeros);
}

/* Matrices of small integers, mostly 0: as the singular values with their vectors tell. */
static void test_beside(int m, int n)
{
    static double a[MOST * MOST];
    double b[MOST] = { 0 }, x[MOST], bound = 0;
    struct lin_dense A = { m, n, a };
    struct lin_least out;
    int rank;
    for (int i = 0; i < m * n; i++)
        a[i] = uniform() < 0.6 ? 0 : nearbyint(3 * uniform());
    bool zero = true;
    for (int i = 0; i < m * n; i++)
        zero = zero && a[i] == 0;
    CHECK(lin_least_norm(&A, b, 1e-10, x, &out) && lin_rank(&A, 1e-10, 0, &bound, &rank));
    CHECK(rank == (zero ? 0 : out.rank), "%d x %d: %d, not %d", m, n, rank, out.rank);
    CHECK(fabs(bound - 1e-10 * out.largest) < 1e-13 * bound || zero);
}

static void test_edges(void)
{
    double hilbert[9], bad[] = { 1, NAN }, zero[] = { 0, 0 }, tiny[] = { 1e-300, 0, 0, 1e-305 }, huge[] = { 1e300, 0, 0, 1e305 }, bound = 0;
    int rank = 7;
    for (int i = 0; i < 9; i++)
        hilbert[i] = 1.0 / (1 + i / 3 + i % 3);
    const double values[] = { 1.4083189271236540, 0.12232706585390584, 0.0026873403557735 };      /* from the literature */
    struct lin_dense H = { 3, 3, hilbert }, none = { 0, 2, NULL }, narrow = { 2, 0, NULL }, nan_ = { 1, 2, bad }, Z = { 2, 1, zero };
    for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++) {
            bound = values[k] * (side ? 1 + 1e-12 : 1 - 1e-12);
            CHECK(lin_rank(&H, 0, 0, &bound, &rank) && rank == (side ? k : k + 1), "value %d, side %d: %d", k, side, rank);
        }
    bound = 0;
    CHECK(lin_rank(&none, 1e-10, 0, &bound, &rank) && rank == 0 && bound == 0);
    CHECK(lin_rank(&narrow, 1e-10, 0, &bound, &rank) && rank == 0);
    CHECK(lin_rank(&Z, 1e-10, 0, &bound, &rank) && rank == 0 && bound == 0);
    CHECK(!lin_rank(&nan_, 1e-10, 0, &bound, &rank) && rank == 0);
    struct lin_dense T = { 2, 2, tiny }, U = { 2, 2, huge };
    bound = 0;
    CHECK(lin_rank(&T, 1e-4, 0, &bound, &rank) && rank == 1);
    bound = 0;
    CHECK(lin_rank(&T, 1e-6, 0, &bound, &rank) && rank == 2);
    bound = 0;
    CHECK(lin_rank(&U, 1e-4, 0, &bound, &rank) && rank == 1);
    bound = 0;
    CHECK(lin_rank(&U, 1e-6, 0, &bound, &rank) && rank == 2);
}

int main(void)
{
    lin_init();
    state = check_seed(3);
    for (int run = 0; run < check_scale(60); run++) {
        int m = 1 + run % MOST, n = 1 + (run * 7) % MOST, least = m < n ? m : n;
        test_constructed(m, n, run % 3 < least ? run % 3 : 0, run % 2 ? 1.3 : 40, pow(10, (run % 5 - 2) * 60));
        test_beside(m, n);
    }
    test_edges();
    return CHECK_END();
}
