/* Normal equations against the SVD, and what must be refused. */
#include "lin_normal.h"

#include <math.h>

#include "check.h"
#include "lin_dense.h"
#include "lin_sparse.h"

static unsigned long state;
static double uniform(void)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (double)(state >> 33) / (1ul << 30) - 1;
}

static int below(int n) { return (int)(fabs(uniform()) * n) % n; }

enum { N = 60, ENTRIES = 400 };

static struct lin_sparse *random_wide(int c, int n, int more)
{
    int row[ENTRIES], col[ENTRIES], count = 0;
    for (int i = 0; i < c; i++, count++)
        row[count] = col[count] = i;
    for (int k = 0; k < more; k++, count++) {
        row[count] = below(c);
        col[count] = below(n);
    }
    return lin_sparse_from_entries(c, n, count, row, col, NULL);
}

static void random_steps(int runs)
{
    int taken = 0;
    for (int run = 0; run < runs; run++) {
        int c = 1 + below(30), n = c + below(N - 30);
        struct lin_sparse *J = random_wide(c, n, below(4 * c));
        struct lin_normal *s = lin_normal_new(J);
        CHECK(s, "run %d", run);
        for (int turn = 0; turn < 3 && s; turn++) {
            double a[N * N] = { 0 }, r[N], b[N], d[N], e[N];
            struct lin_least out;
            for (int i = 0; i < c; i++) {
                r[i] = uniform();
                b[i] = -r[i];
                double size = exp(10 * uniform() * (turn == 2));       /* rows of any length */
                for (int m = J->ptr[i]; m < J->ptr[i + 1]; m++)
                    a[i * n + J->col[m]] = J->val[m] = size * (uniform() + (J->col[m] == i));
            }
            struct lin_dense A = { c, n, a };
            if (!lin_normal_step(s, J->val, r, d))
                continue;
            taken++;
            CHECK(lin_least_norm(&A, b, 0, e, &out) && out.rank == c, "run %d: rank %d of %d", run, out.rank, c);
            double norm = 0, apart = 0, cond = out.largest / out.smallest_kept;
            for (int j = 0; j < n; j++) {
                norm = fmax(norm, fabs(e[j]));
                apart = fmax(apart, fabs(d[j] - e[j]));
            }
            CHECK(apart < 1e-14 * n * cond * cond * norm, "run %d turn %d: %g of %g, condition %g", run, turn, apart, norm, cond);
        }
        lin_normal_free(s);
        lin_sparse_free(J);
    }
    CHECK(taken > runs, "%d taken", taken);
}

/* The third row is the sum of the first two, nearly; then a value that is no number. */
static void refusals(void)
{
    static const int ptr[] = { 0, 2, 4, 7 }, col[] = { 0, 1, 1, 2, 0, 1, 2 };
    struct lin_sparse *J = lin_sparse_new(3, 3, ptr, col);
    struct lin_normal *s = lin_normal_new(J);
    double val[] = { 1, 2, 3, 4, 1, 5, 4 }, r[] = { 1, 2, 3 }, d[3];
    CHECK(!lin_normal_step(s, val, r, d), "dependent rows");
    val[5] = 5 + 1e-5;
    CHECK(!lin_normal_step(s, val, r, d), "nearly dependent rows");
    val[5] = NAN;
    CHECK(!lin_normal_step(s, val, r, d), "not a number");
    val[5] = 9;
    CHECK(lin_normal_step(s, val, r, d) && fabs(d[0] + 2 * d[1] + 1) < 1e-12 && fabs(3 * d[1] + 4 * d[2] + 2) < 1e-12
          && fabs(d[0] + 9 * d[1] + 4 * d[2] + 3) < 1e-12, "%g %g %g", d[0], d[1], d[2]);
    lin_normal_free(s);
    lin_sparse_free(J);
}

/* A column that all rows share would fill J J^T. */
static void too_full(void)
{
    enum { C = 400 };
    int ptr[C + 1] = { 0 }, col[2 * C];
    for (int i = 0; i < C; i++) {
        ptr[i + 1] = 2 * (i + 1);
        col[2 * i] = 0;
        col[2 * i + 1] = i + 1;
    }
    struct lin_sparse *J = lin_sparse_new(C, C + 1, ptr, col);
    CHECK(!lin_normal_new(J), "a full product");
    lin_sparse_free(J);
    J = lin_sparse_new(0, 3, ptr, col);
    CHECK(!lin_normal_new(J), "no rows");
    lin_sparse_free(J);
}

int main(void)
{
    state = check_seed(31);
    random_steps(check_scale(300));
    refusals();
    too_full();
    return CHECK_END();
}
