/* Sparse matrices and square solves: known solutions are found again, within rounding
 * times the condition and the growth that reused pivots are allowed. */
#include "lin_lu.h"

#include <math.h>
#include <string.h>

#include "check.h"
#include "lin_sparse.h"

static unsigned long state;
static double uniform(void)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (double)(state >> 33) / (1ul << 30) - 1;
}

static struct lin_sparse *random_square(int n, int extra)
{
    int row[400], col[400], count = 0;
    for (int i = 0; i < n; i++, count++) {
        row[count] = i;
        col[count] = (i + 1) % n;   /* nonsingular pattern with an empty diagonal */
    }
    for (; count < n + extra; count++) {
        row[count] = (int)(fabs(uniform()) * n) % n;
        col[count] = (int)(fabs(uniform()) * n) % n;
    }
    return lin_sparse_from_entries(n, n, count, row, col, NULL);
}

static double solve_error(struct lin_lu *lu, const struct lin_sparse *a, int transposed)
{
    double x[60], b[60], worst = 0;
    for (int i = 0; i < a->rows; i++)
        x[i] = uniform();
    if (transposed) {
        lin_sparse_transpose_times(a, x, b);
        lin_lu_solve_transposed(lu, b);
    } else {
        lin_sparse_times(a, x, b);
        lin_lu_solve(lu, b);
    }
    for (int i = 0; i < a->rows; i++)
        worst = fmax(worst, fabs(x[i] - b[i]));
    return worst * lin_lu_rcond(lu);
}

static void test_random(void)
{
    for (int run = 0; run < check_scale(60); run++) {
        int n = 2 + run % 50;
        struct lin_sparse *a = random_square(n, 3 * n);
        struct lin_lu *lu = lin_lu_new(a);
        for (int turn = 0; turn < 5; turn++) {
            for (int k = 0; k < a->ptr[n]; k++)
                a->val[k] = uniform() * (turn == 3 ? exp(12 * uniform()) : 1);
            bool ok = lin_lu_factor(lu, a->val);
            CHECK(ok, "run %d turn %d", run, turn);
            if (!ok)
                continue;
            double e = solve_error(lu, a, 0), f = solve_error(lu, a, 1);
            CHECK(e < 3e-12 && f < 3e-12, "run %d turn %d: %g %g", run, turn, e, f);
        }
        struct lin_lu_counts counts = lin_lu_counts(lu);
        CHECK(counts.fresh >= 1 && counts.fresh + counts.reused >= 5);
        lin_lu_free(lu);
        lin_sparse_free(a);
    }
}

/* The old pivot becomes tiny: reusing it would lose everything. */
static void test_bad_refactor(void)
{
    int ptr[] = {0, 2, 4}, col[] = {0, 1, 0, 1};
    struct lin_sparse *a = lin_sparse_new(2, 2, ptr, col);
    struct lin_lu *lu = lin_lu_new(a);
    double good[] = {1, 2, 3, 4}, bad[] = {1e-18, 1, 1, 1}, zero[] = {0, 1, 1, 0};
    CHECK(lin_lu_factor(lu, good) && lin_lu_factor(lu, bad));
    double b[] = {1, 2};            /* solution 1, 1 to rounding */
    lin_lu_solve(lu, b);
    CHECK(fabs(b[0] - 1) < 1e-15 && fabs(b[1] - 1) < 1e-15, "%g %g", b[0], b[1]);
    CHECK(lin_lu_factor(lu, zero));
    double c[] = {5, 7};
    lin_lu_solve(lu, c);
    CHECK(c[0] == 7 && c[1] == 5);
    lin_lu_free(lu);
    lin_sparse_free(a);
}

static void test_singular(void)
{
    int ptr[] = {0, 2, 4}, col[] = {0, 1, 0, 1};
    struct lin_sparse *a = lin_sparse_new(2, 2, ptr, col);
    struct lin_lu *lu = lin_lu_new(a);
    double same[] = {1, 2, 1, 2}, good[] = {1, 2, 3, 4}, nan_[] = {1, NAN, 3, 4};
    CHECK(!lin_lu_factor(lu, same) && lin_lu_rcond(lu) == 0);
    CHECK(lin_lu_factor(lu, good));
    /* 1-norm condition of [1 2; 3 4] is 6 * 3.5 */
    CHECK(fabs(lin_lu_rcond(lu) * 21 - 1) < 1e-12, "%g", 1 / lin_lu_rcond(lu));
    CHECK(!lin_lu_factor(lu, nan_) && !lin_lu_factor(lu, same));
    CHECK(lin_lu_factor(lu, good));
    lin_lu_free(lu);
    lin_sparse_free(a);

    int ptr1[] = {0, 1, 2}, col1[] = {0, 0};     /* structurally singular */
    a = lin_sparse_new(2, 2, ptr1, col1);
    lu = lin_lu_new(a);
    double ones[] = {1, 1};
    CHECK(!lin_lu_factor(lu, ones));
    lin_lu_free(lu);
    lin_sparse_free(a);

    a = lin_sparse_new(0, 0, NULL, NULL);
    lu = lin_lu_new(a);
    CHECK(lin_lu_factor(lu, a->val) && lin_lu_rcond(lu) == 1);
    lin_lu_solve(lu, ones);
    CHECK(ones[0] == 1);
    lin_lu_free(lu);
    lin_sparse_free(a);
}

/* Repeated positions share a place. */
static void test_entries(void)
{
    int row[] = {1, 0, 1, 1}, col[] = {2, 0, 0, 2}, place[4];
    double v[] = {10, 20, 30, 40}, x[] = {1, 2, 3}, y[2], z[3];
    struct lin_sparse *a = lin_sparse_from_entries(2, 3, 4, row, col, place);
    CHECK(a->ptr[1] == 1 && a->ptr[2] == 3 && place[0] == place[3] && place[0] != place[2]);
    for (int k = 0; k < 4; k++)
        a->val[place[k]] += v[k];
    lin_sparse_times(a, x, y);
    CHECK(y[0] == 20 && y[1] == 180, "%g %g", y[0], y[1]);
    lin_sparse_transpose_times(a, y, z);
    CHECK(z[0] == 5800 && z[1] == 0 && z[2] == 9000, "%g %g %g", z[0], z[1], z[2]);
    lin_sparse_free(a);
    lin_sparse_free(NULL);
    lin_lu_free(NULL);
}

int main(void)
{
    state = check_seed(1);
    test_entries();
    test_random();
    test_bad_refactor();
    test_singular();
    return CHECK_END();
}
