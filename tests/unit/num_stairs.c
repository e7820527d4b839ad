/* Rows in groups: what they solve, bounds of their least singular value against the SVD, and what makes no stairs. */
#include "lin_stairs.h"

#include <math.h>

#include "check.h"
#include "least_singular.h"
#include "lin_dense.h"
#include "lin_sparse.h"

static unsigned long state;
static double uniform(void)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (double)(state >> 33) / (1ul << 30) - 1;
}

static int below(int n) { return (int)(fabs(uniform()) * n) % n; }

enum { N = 80, MOST = 2000 };

/* Rows of `groups` groups, each with as many new columns as rows, some more, and entries in columns of earlier groups; rows and columns in any order. */
static struct lin_sparse *random_stairs(int groups, int *group, double weak)
{
    static int row[MOST], col[MOST], place[MOST], at[N], to[N];
    double val[MOST];
    int rows = 0, cols = 0, count = 0;
    for (int g = 0; g < groups; g++) {
        int m = 2 + below(6), n = m + below(4), first = cols;
        for (int i = 0; i < m; i++) {
            for (int k = 0; k < 3; k++) {
                row[count] = rows + i;
                col[count] = k ? first + below(n) : first + i;
                val[count++] = k ? 0.3 * uniform() : 1 + 0.2 * uniform();
            }
            for (int k = 0; k < 2 && first; k++) {
                row[count] = rows + i;
                col[count] = below(first);
                val[count++] = weak * uniform();
            }
            group[rows + i] = g;
        }
        rows += m;
        cols += n;
    }
    for (int k = 0; k < N; k++)
        at[k] = to[k] = k;
    for (int k = cols - 1; k > 0; k--) {
        int j = below(k + 1), t = to[k];
        to[k] = to[j];
        to[j] = t;
    }
    for (int k = rows - 1; k > 0; k--) {
        int j = below(k + 1), t = at[k], g = group[k];
        at[k] = at[j];
        at[j] = t;
        group[k] = group[j];
        group[j] = g;
    }
    int back[N];
    for (int k = 0; k < rows; k++)
        back[at[k]] = k;
    for (int e = 0; e < count; e++) {
        row[e] = back[row[e]];
        col[e] = to[col[e]];
    }
    struct lin_sparse *J = lin_sparse_from_entries(rows, cols, count, row, col, place);
    for (int e = 0; e < count; e++)
        J->val[place[e]] += val[e];
    return J;
}

static double least_of(const struct lin_sparse *J, const double *b, double *x)
{
    double a[N * N] = { 0 };
    struct lin_least out;
    for (int i = 0; i < J->rows; i++)
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++)
            a[i * J->cols + J->col[e]] = J->val[e];
    struct lin_dense A = { J->rows, J->cols, a };
    CHECK(lin_least_norm(&A, b, 0, x, &out) && out.rank == J->rows, "rank %d of %d", out.rank, J->rows);
    return out.smallest_kept;
}

static void random_runs(int runs)
{
    int near = 0;
    for (int run = 0; run < runs; run++) {
        int group[N], groups = 1 + below(4);
        struct lin_sparse *J = random_stairs(groups, group, run % 2 ? 0.1 : 1);
        struct lin_stairs s;
        double r[N], d[N], x[N], b[N];
        CHECK(lin_stairs_init(&s, J, group, groups), "run %d", run);
        for (int i = 0; i < J->rows; i++) {
            r[i] = uniform();
            b[i] = -r[i];
        }
        double least = least_of(J, b, x), bound = num_least_singular_stairs(&s, NULL), whole = num_least_singular(J, NULL);
        CHECK(bound > 0 && bound <= least * (1 + 1e-9), "run %d: bound %g, least %g", run, bound, least);
        CHECK(whole <= least * (1 + 1e-9) && whole > 0.2 * least, "run %d: bound %g, least %g", run, whole, least);
        near += bound > 0.1 * least;
        CHECK(lin_stairs_factor(&s, 1e-6) && lin_stairs_solve(&s, r, d), "run %d", run);
        double off = 0, apart = 0;
        for (int i = 0; i < J->rows; i++) {
            double sum = r[i];
            for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++)
                sum += J->val[e] * d[J->col[e]];
            off = fmax(off, fabs(sum));
        }
        for (int j = 0; j < J->cols; j++)
            apart = fmax(apart, fabs(d[j] - x[j]));
        CHECK(off < 1e-10, "run %d: residual %g", run, off);
        CHECK(groups > 1 || apart < 1e-9, "run %d: %g from that of least norm", run, apart);
        lin_stairs_clear(&s);
        lin_sparse_free(J);
    }
    CHECK(near > runs / 2, "%d near", near);
}

static bool stands(int rows, int cols, const int *ptr, const int *col, const double *val, const int *group, int groups, double *bound)
{
    struct lin_sparse *J = lin_sparse_new(rows, cols, ptr, col);
    for (int e = 0; e < ptr[rows]; e++)
        J->val[e] = val[e];
    struct lin_stairs s;
    bool is = lin_stairs_init(&s, J, group, groups);
    *bound = is ? num_least_singular_stairs(&s, NULL) : 0;
    bool factors = is && lin_stairs_factor(&s, 1e-6);
    CHECK(!is || factors == (*bound > 0), "factors %d, bound %g", factors, *bound);
    lin_stairs_clear(&s);
    lin_sparse_free(J);
    return is;
}

static void refusals(void)
{
    static const int ptr[] = { 0, 2, 4 }, same[] = { 0, 1, 0, 1 }, next[] = { 0, 1, 1, 2 }, apart[] = { 0, 1, 2, 3 }, one[] = { 0, 0 }, two[] = { 0, 1 };
    static const double val[] = { 1, 2, 1, 3 }, twice[] = { 1, 2, 2, 4 };
    double bound;
    CHECK(stands(2, 2, ptr, same, val, one, 1, &bound) && bound > 0.1, "one group %g", bound);
    CHECK(!stands(2, 2, ptr, same, val, two, 2, &bound), "the second group has no new column");
    CHECK(stands(2, 3, ptr, next, val, two, 2, &bound) && bound > 0.3 && bound < 3, "%g", bound);
    CHECK(stands(2, 2, ptr, same, twice, one, 1, &bound) && bound == 0, "dependent rows %g", bound);
    CHECK(!stands(2, 1, (const int[]){ 0, 1, 2 }, (const int[]){ 0, 0 }, val, NULL, 0, &bound), "more rows than columns");
    /* diagonal: the bound of stairs without couplings is 1 over the length of both inverses, 1 / |(1/sqrt 5, 1/sqrt 10)| */
    CHECK(stands(2, 4, ptr, apart, val, two, 2, &bound) && bound < 1 / sqrt(1.0 / 5 + 1.0 / 10) && bound > 0.49 / sqrt(1.0 / 5 + 1.0 / 10), "%g", bound);
}

/* Far below roundings of a square: rows of length 1 and an angle of 1e-10 to each other, seen in double-doubles. */
static void nearly_dependent(void)
{
    static const int ptr[] = { 0, 2, 4 }, col[] = { 0, 1, 0, 1 };
    double val[] = { 1, 0, 1, 1e-10 }, bound;
    struct lin_sparse *J = lin_sparse_new(2, 2, ptr, col);
    for (int e = 0; e < 4; e++)
        J->val[e] = val[e];
    bound = num_least_singular(J, NULL);
    CHECK(bound > 1e-11 && bound <= 1e-10 / sqrt(2), "%g", bound);
    J->val[3] = 0;
    CHECK(num_least_singular(J, NULL) == 0, "dependent");
    lin_sparse_free(J);
}

/* One row nearly the sum of two others, nearer and nearer: in doubles by the roundings that may be, by those that were, and in double-doubles. */
static void nearer(void)
{
    enum { M = 24, W = 30 };
    for (int run = 0; run < 40; run++) {
        double size = pow(10, -run / 4.0), a[M][W], b[N] = { 0 }, x[N];
        int row[M * W], col[M * W], place[M * W];
        for (int i = 0; i < M; i++)
            for (int j = 0; j < W; j++)
                a[i][j] = uniform();
        for (int j = 0; j < W; j++)
            a[M - 1][j] = a[0][j] + a[1][j] + size * uniform();
        for (int e = 0; e < M * W; e++) {
            row[e] = e / W;
            col[e] = e % W;
        }
        struct lin_sparse *J = lin_sparse_from_entries(M, W, M * W, row, col, place);
        for (int e = 0; e < M * W; e++)
            J->val[place[e]] = a[e / W][e % W];
        double least = least_of(J, b, x), bound = num_least_singular(J, NULL);
        CHECK(bound <= least * (1 + 1e-6) + 1e-14 && bound > 0.1 * least, "beside by %g: bound %g, least %g", size, bound, least);
        lin_sparse_free(J);
    }
}

int main(void)
{
    state = check_seed(17);
    random_runs(check_scale(300));
    refusals();
    nearly_dependent();
    nearer();
    return CHECK_END();
}
