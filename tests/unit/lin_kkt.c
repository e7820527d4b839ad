/* Least-norm corrections, sparse against dense and against what defines them: the
 * conditions hold, and W^2 (d - g) is a combination of J's rows. */
#include "lin_kkt.h"

#include <math.h>
#include <string.h>

#include "check.h"
#include "lin.h"
#include "lin_dense.h"
#include "lin_lu.h"
#include "lin_sparse.h"

static unsigned long state;
static double uniform(void)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (double)(state >> 33) / (1ul << 30) - 1;
}

static struct lin_sparse *random_wide(int c, int n)
{
    int row[600], col[600], count = 0;
    for (int i = 0; i < c; i++, count++) {
        row[count] = i;
        col[count] = i;
    }
    for (int k = 0; k < 2 * c; k++, count++) {
        row[count] = (int)(fabs(uniform()) * c) % c;
        col[count] = (int)(fabs(uniform()) * n) % n;
    }
    return lin_sparse_from_entries(c, n, count, row, col, NULL);
}

enum { N = 40 };

static void test_random(void)
{
    for (int run = 0; run < check_scale(100); run++) {
        int c = 1 + run % 15, n = c + 1 + (run * 7) % (N - 16);
        struct lin_sparse *J = random_wide(c, n);
        struct lin_kkt *k = lin_kkt_new(J);
        for (int turn = 0; turn < 4; turn++) {
            double w[N], r[N], g[N], d[N], e[N], Jd[N];
            bool held[N];
            for (int m = 0; m < J->ptr[c]; m++)
                J->val[m] = uniform();
            for (int j = 0; j < n; j++) {
                w[j] = exp((turn == 2 ? 10 : 1) * uniform());
                g[j] = uniform();
                held[j] = turn == 1 && j >= c && uniform() > 0;
            }
            for (int i = 0; i < c; i++)
                r[i] = uniform();
            if (!lin_kkt_factor(k, J->val, w, held)) {
                CHECK(false, "run %d turn %d", run, turn);
                continue;
            }
            const double *with = turn % 2 ? NULL : g;
            lin_kkt_solve(k, r, with, d);
            struct lin_correction p = {J, w, held, r, with};
            struct lin_least out;
            CHECK(lin_correction_dense(&p, 0, e, &out) && out.rank == c);
            double ratio = lin_kkt_rcond(k) * out.largest / out.smallest_kept;
            CHECK(ratio > 0.2 && ratio < 5, "run %d: %g", run, ratio);
            lin_sparse_times(J, d, Jd);
            double worst = 0, apart = 0, tol = 1e-13 / lin_kkt_rcond(k);
            for (int i = 0; i < c; i++) {
                double terms = fabs(r[i]);
                for (int m = J->ptr[i]; m < J->ptr[i + 1]; m++)
                    terms += fabs(J->val[m] * d[J->col[m]]);
                worst = fmax(worst, fabs(Jd[i] + r[i]) / terms);
            }
            for (int j = 0; j < n; j++) {
                apart = fmax(apart, fabs(d[j] - e[j]) * w[j]);
                if (held[j])
                    CHECK(d[j] == 0 && e[j] == 0);
            }
            CHECK(worst < 1e-13 + 0.01 * tol, "run %d turn %d conditions: %g", run, turn, worst);
            CHECK(apart < 100 * tol * exp(turn == 2 ? 10 : 1), "run %d turn %d apart: %g", run, turn, apart);
        }
        lin_kkt_free(k);
        lin_sparse_free(J);
    }
}

/* One condition a.d = -r: d = -r W^-2 a / (a W^-2 a), and with g the nearest point. */
static void test_by_hand(void)
{
    int ptr[] = {0, 2}, col[] = {0, 1};
    struct lin_sparse *J = lin_sparse_new(1, 2, ptr, col);
    struct lin_kkt *k = lin_kkt_new(J);
    double val[] = {3, 4}, w[] = {1, 2}, r[] = {13}, g[] = {1, 1}, d[2];
    CHECK(lin_kkt_factor(k, val, w, NULL));
    lin_kkt_solve(k, r, NULL, d);
    CHECK(fabs(d[0] + 3) < 1e-14 && fabs(d[1] + 1) < 1e-14, "%g %g", d[0], d[1]);
    lin_kkt_solve(k, r, g, d);          /* from g: 13 + 7 = 20 to go, along (3, 1)/13 */
    CHECK(fabs(d[0] - (1 - 60. / 13)) < 1e-14 && fabs(d[1] - (1 - 20. / 13)) < 1e-14);
    lin_kkt_free(k);
    lin_sparse_free(J);
}

/* Dependent rows are told from nearly dependent ones, and the dense way goes on. */
static void test_dependent(void)
{
    int ptr[] = {0, 3, 6, 9}, col[] = {0, 1, 2, 0, 1, 2, 0, 1, 2};
    struct lin_sparse *J = lin_sparse_new(3, 3, ptr, col);
    struct lin_kkt *k = lin_kkt_new(J);
    for (double eps = 1e-2; eps > 5e-12; eps *= 0.1) {
        double a[] = {1, 2, 3, 4, 5, 6, 5, 7, 9 + eps};
        double x[] = {1, -1, 2}, r[3], d[3];
        memcpy(J->val, a, sizeof a);
        lin_sparse_times(J, x, r);
        CHECK(lin_kkt_factor(k, a, NULL, NULL), "%g", eps);
        double rc = lin_kkt_rcond(k);
        CHECK(rc > 0.005 * eps && rc < 0.2 * eps, "%g: %g", eps, rc);
        lin_kkt_solve(k, r, NULL, d);
        double worst = 0;
        for (int j = 0; j < 3; j++)
            worst = fmax(worst, fabs(d[j] + x[j]));
        CHECK(worst < 1e-14 / rc, "%g: %g", eps, worst);
    }
    double a[] = {1, 2, 3, 4, 5, 6, 5, 7, 9}, r[] = {1, 1, 2}, d[3], Jd[3];
    CHECK(!lin_kkt_factor(k, a, NULL, NULL) && lin_kkt_rcond(k) < 1e-13);
    memcpy(J->val, a, sizeof a);
    struct lin_correction p = {J, NULL, NULL, r, NULL};
    struct lin_least out;
    CHECK(lin_correction_dense(&p, 1e-10, d, &out) && out.rank == 2 && out.residual < 1e-14);
    lin_sparse_times(J, d, Jd);
    CHECK(fabs(Jd[0] + 1) + fabs(Jd[1] + 1) + fabs(Jd[2] + 2) < 1e-13);
    CHECK(fabs(d[0] - 2 * d[1] + d[2]) < 1e-14);     /* orthogonal to the kernel (1,-2,1) */
    double zero_row[] = {1, 2, 3, 0, 0, 0, 5, 7, 8}, w[] = {1, 0, 1};
    CHECK(!lin_kkt_factor(k, zero_row, NULL, NULL));
    CHECK(!lin_kkt_factor(k, zero_row, w, NULL));
    bool held[] = {true, true, true};
    CHECK(!lin_kkt_factor(k, a, NULL, held));
    lin_kkt_free(k);
    lin_sparse_free(J);
}

/* Sizes of 1e+-150 in rows, columns and weights are scaled away. */
static void test_extreme(void)
{
    int ptr[] = {0, 2, 4}, col[] = {0, 1, 1, 2};
    struct lin_sparse *J = lin_sparse_new(2, 3, ptr, col);
    struct lin_kkt *k = lin_kkt_new(J);
    double plain[] = {1, 2, 3, 4}, r[] = {1, 2}, d[3], e[3];
    double big[] = {1e-150, 2, 3e150, 4}, w[] = {1e-150, 1, 1e-150}, rb[] = {1, 2e150};
    CHECK(lin_kkt_factor(k, plain, NULL, NULL));
    lin_kkt_solve(k, r, NULL, d);
    CHECK(lin_kkt_factor(k, big, w, NULL));
    lin_kkt_solve(k, rb, NULL, e);
    CHECK(fabs(e[0] / 1e150 - d[0]) < 1e-14 && fabs(e[1] - d[1]) < 1e-14 &&
          fabs(e[2] / 1e150 - d[2]) < 1e-14, "%g %g %g", e[0], e[1], e[2]);
    lin_kkt_free(k);
    lin_sparse_free(J);
}

/* A chain of many links fills in linearly. */
static void test_chain(void)
{
    int fill[2];
    for (int big = 0; big < 2; big++) {
        int c = big ? 4000 : 1000, n = 2 * c, count = 0;
        int *row = malloc(sizeof *row * (size_t)c * 4), *col = malloc(sizeof *col * (size_t)c * 4);
        for (int i = 0; i < c; i++)
            for (int j = 0; j < 4; j++)
                if (2 * i + j - 1 >= 0 && 2 * i + j - 1 < n) {
                    row[count] = i;
                    col[count++] = 2 * i + j - 1;
                }
        struct lin_sparse *J = lin_sparse_from_entries(c, n, count, row, col, NULL);
        for (int m = 0; m < count; m++)
            J->val[m] = uniform();
        struct lin_kkt *k = lin_kkt_new(J);
        CHECK(lin_kkt_factor(k, J->val, NULL, NULL));
        fill[big] = lin_kkt_counts(k).fill;
        CHECK(lin_kkt_factor(k, J->val, NULL, NULL) && lin_kkt_counts(k).reused == 1);
        lin_kkt_free(k);
        lin_sparse_free(J);
        free(row);
        free(col);
    }
    CHECK(fill[1] < 4.5 * fill[0] && fill[0] < 40000, "%d %d", fill[0], fill[1]);
}

static void test_empty(void)
{
    int ptr[] = {0};
    struct lin_sparse *J = lin_sparse_new(0, 2, ptr, NULL);
    struct lin_kkt *k = lin_kkt_new(J);
    double g[] = {1, 2}, d[2];
    CHECK(lin_kkt_factor(k, J->val, NULL, NULL) && lin_kkt_rcond(k) == 1);
    lin_kkt_solve(k, NULL, g, d);
    CHECK(d[0] == 1 && d[1] == 2);
    lin_kkt_free(k);
    lin_sparse_free(J);
    lin_kkt_free(NULL);
}

/* Rows with four entries: along a chain, over a plane grid, and across a random graph. */
static void test_fill(void)
{
    enum { SIDE = 60, C = SIDE * SIDE };
    static int row[4 * C], col[4 * C];
    static const bool fills[] = { false, false, true };
    for (int kind = 0; kind < 3; kind++) {
        for (int i = 0; i < C; i++) {
            int near[] = { (i + 1) % C, (i + 2) % C, (i + 3) % C }, grid[] = { i % SIDE ? i - 1 : i + 1, (i + 1) % C, (i + SIDE) % C };
            for (int k = 0; k < 4; k++) {
                row[4 * i + k] = i;
                col[4 * i + k] = !k ? C + i : kind == 0 ? near[k - 1] : kind == 1 ? grid[k - 1] : (int)(fabs(uniform()) * C) % C;
            }
        }
        struct lin_sparse *J = lin_sparse_from_entries(C, 2 * C, 4 * C, row, col, NULL);
        struct lin_kkt *k = lin_kkt_new(J);
        CHECK(lin_kkt_fills(k) == fills[kind], "kind %d", kind);
        lin_kkt_free(k);
        lin_sparse_free(J);
    }
}

int main(void)
{
    lin_init();
    state = check_seed(2);
    test_by_hand();
    test_random();
    test_dependent();
    test_extreme();
    test_chain();
    test_empty();
    test_fill();
    return CHECK_END();
}
