/* Ranks, combinations and reduced forms of random integer rows, beside FLINT's dense matrices. */
#include <flint/fmpq_mat.h>

#include "check.h"
#include "exact_basis.h"
#include "exact_rank.h"

enum { MOST = 14 };

static flint_rand_t source;

static int below(int n)
{
    return (int)n_randint(source, (ulong)n);
}

/* rows x cols of rank at most r, sparse or dense, with entries of so many bits. */
static void random_matrix(fmpz_mat_t m, int r, int bits)
{
    fmpz_mat_t a, b;
    fmpz_mat_init(a, fmpz_mat_nrows(m), r);
    fmpz_mat_init(b, r, fmpz_mat_ncols(m));
    fmpz_mat_randtest(a, source, (mp_bitcnt_t)bits);
    fmpz_mat_randtest(b, source, (mp_bitcnt_t)bits);
    for (int i = 0; i < fmpz_mat_nrows(a); i++)
        for (int j = 0; j < r; j++)
            if (below(3) == 0)
                fmpz_zero(fmpz_mat_entry(a, i, j));
    fmpz_mat_mul(m, a, b);
    fmpz_mat_clear(a);
    fmpz_mat_clear(b);
}

static struct exact_row row_of(const fmpz_mat_t m, int i)
{
    struct exact_row r = { 0 };
    for (int j = 0; j < fmpz_mat_ncols(m); j++)
        exact_row_push(&r, j, fmpz_mat_entry(m, i, j));
    return r;
}

/* den * b = sum of factor * row, by the definition. */
static bool adds_up(const struct exact_echelon *e, const struct exact_row *b, const struct exact_combination *c)
{
    struct exact_sum s;
    exact_sum_init(&s, e->cols);
    exact_sum_add(&s, b, c->den);
    for (int k = 0; k < c->count; k++)
        exact_sum_subtract(&s, e->given[e->pivot[c->pivot[k]].row], c->factor + k);
    bool zero = exact_sum_is_zero(&s) && fmpz_sgn(c->den) > 0;
    exact_sum_clear(&s);
    return zero;
}

static void combinations(int which, int bits)
{
    int rows = below(MOST), cols = 1 + below(MOST), first = rows ? below(rows + 1) : 0;
    fmpz_mat_t m;
    fmpz_mat_init(m, rows, cols);
    random_matrix(m, below(MOST), bits);
    struct exact_row row[MOST];
    const struct exact_row *list[MOST];
    struct exact_echelon e;
    for (int i = 0; i < rows; i++) {
        row[i] = row_of(m, i);
        list[i] = row + i;
    }
    exact_echelon_init(&e, cols, which);
    bool ok = exact_echelon_add(&e, list, first, NULL, NULL) && exact_echelon_add(&e, list + first, rows - first, NULL, NULL);
    CHECK(ok && e.pivots == fmpz_mat_rank(m), "%d x %d", rows, cols);
    for (int i = 0; i < rows; i++) {
        struct exact_combination c;
        enum exact_found found = exact_combine(&e, row + i, true, &c, NULL, NULL);
        CHECK(found == EXACT_YES && adds_up(&e, row + i, &c));
        CHECK(e.pivot_of_row[i] < 0 || (c.count == 1 && c.pivot[0] == e.pivot_of_row[i] && fmpz_equal(c.factor, c.den)));
        exact_combination_clear(&c);
    }
    if (e.pivots < cols) {                /* a row beyond the others' span */
        struct exact_row other = { 0 };
        struct exact_combination c;
        fmpz_t one;
        int col = 0;
        fmpz_init_set_ui(one, 1);
        while (e.pivot_of[col] >= 0)
            col++;
        exact_row_push(&other, col, one);
        fmpz_mat_t more;
        fmpz_mat_init(more, rows + 1, cols);
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < cols; j++)
                fmpz_set(fmpz_mat_entry(more, i, j), fmpz_mat_entry(m, i, j));
        fmpz_one(fmpz_mat_entry(more, rows, col));
        enum exact_found found = exact_combine(&e, &other, true, &c, NULL, NULL);
        CHECK((found == EXACT_YES) == (fmpz_mat_rank(more) == e.pivots));
        exact_combination_clear(&c);
        fmpz_mat_clear(more);
        exact_row_clear(&other);
        fmpz_clear(one);
    }
    for (int i = 0; i < rows; i++)
        exact_row_clear(row + i);
    exact_echelon_clear(&e);
    fmpz_mat_clear(m);
}

/* The rows of a basis are as many as the rank, and each is 0 in the others' pivots; every row reduces to 0. */
static void bases(int bits)
{
    int rows = 1 + below(MOST), cols = 1 + below(MOST), linear = 1 + below(cols);
    fmpz_mat_t m, left;
    fmpz_mat_init(m, rows, cols);
    random_matrix(m, below(MOST), bits);
    fmpz_mat_init(left, rows, linear);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < linear; j++)
            fmpz_set(fmpz_mat_entry(left, i, j), fmpz_mat_entry(m, i, j));
    struct exact_basis b;
    fmpq_t factor;
    bool met;
    fmpq_init(factor);
    exact_basis_init(&b, linear);
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < rows; i++) {
            struct exact_row row = row_of(m, i), out = { 0 };
            exact_basis_reduce(&b, &row, cols, &out, factor, &met);
            bool new = out.entries && out.col[0] < linear;
            CHECK(!fmpq_is_zero(factor) && !(pass && new));
            if (new)
                exact_basis_add(&b, &out, cols);
            exact_row_clear(&row);
            exact_row_clear(&out);
        }
    CHECK(b.rows == fmpz_mat_rank(left), "%d rows", b.rows);
    for (int i = 0; i < b.rows; i++)
        for (int k = 0; k < b.row[i].entries; k++)
            CHECK(b.row[i].col[k] >= linear || b.row_of[b.row[i].col[k]] < 0 || b.row_of[b.row[i].col[k]] == i);
    fmpq_clear(factor);
    exact_basis_clear(&b);
    fmpz_mat_clear(m);
    fmpz_mat_clear(left);
}

/* A tridiagonal matrix of 3000 rows stays sparse, and a row that follows from all is found by few digits. */
static void long_chain(void)
{
    enum { N = 3000 };
    static struct exact_row row[N + 1];
    static const struct exact_row *list[N + 1];
    struct exact_sum sum;
    struct exact_echelon e;
    struct exact_combination c;
    fmpz_t v;
    fmpz_init(v);
    exact_sum_init(&sum, N);
    for (int i = 0; i < N; i++) {
        for (int j = i ? i - 1 : 0; j <= i + 1 && j < N; j++) {
            fmpz_set_si(v, j == i ? 4 : -1);
            exact_row_push(row + i, j, v);
        }
        list[i] = row + i;
        fmpz_set_si(v, i % 5 - 2);
        exact_sum_add(&sum, row + i, v);
    }
    exact_sum_take(&sum, row + N);
    list[N] = row + N;
    exact_echelon_init(&e, N, 0);
    CHECK(exact_echelon_add(&e, list, N, NULL, NULL) && exact_echelon_add(&e, list + N, 1, NULL, NULL) && e.pivots == N);
    long entries = 0;
    for (int q = 0; q < e.pivots; q++)
        entries += e.pivot[q].entries;
    CHECK(entries < 3 * N, "%ld entries", entries);
    CHECK(exact_combine(&e, row + N, true, &c, NULL, NULL) == EXACT_YES && adds_up(&e, row + N, &c) && fmpz_is_one(c.den));
    exact_combination_clear(&c);
    exact_echelon_clear(&e);
    exact_sum_clear(&sum);
    for (int i = 0; i <= N; i++)
        exact_row_clear(row + i);
    fmpz_clear(v);
}

/* Long rows beside short ones that were there before: combinations of these, others, and some of both. */
static void wide_rows(void)
{
    enum { SHORT = 90, WIDE = 30, ROWS = SHORT + WIDE, COLS = 160 };
    static struct exact_row row[ROWS];
    static const struct exact_row *list[ROWS];
    struct exact_echelon e;
    fmpz_mat_t m;
    fmpz_mat_init(m, ROWS, COLS);
    for (int i = 0; i < SHORT; i++)
        for (int k = 0; k < 4; k++)
            fmpz_set_si(fmpz_mat_entry(m, i, below(COLS)), below(9) - 4);
    for (int i = SHORT; i < ROWS; i++) {
        for (int k = 0; k < SHORT && i % 3; k++)
            for (int j = 0, factor = below(5) - 2; j < COLS; j++)
                fmpz_addmul_si(fmpz_mat_entry(m, i, j), fmpz_mat_entry(m, k, j), factor);
        for (int k = 0; k < COLS && i % 3 != 1; k++)
            fmpz_add_si(fmpz_mat_entry(m, i, k), fmpz_mat_entry(m, i, k), i % 2 ? below(7) - 3 : below(40) == 0);
    }
    for (int i = 0; i < ROWS; i++) {
        row[i] = row_of(m, i);
        list[i] = row + i;
    }
    exact_echelon_init(&e, COLS, 0);
    CHECK(exact_echelon_add(&e, list, SHORT, NULL, NULL) && exact_echelon_add(&e, list + SHORT, WIDE, NULL, NULL));
    CHECK(e.pivots == fmpz_mat_rank(m), "%d pivots, rank %ld", e.pivots, fmpz_mat_rank(m));
    for (int i = 0; i < ROWS; i++) {
        struct exact_combination c;
        CHECK(exact_combine(&e, row + i, true, &c, NULL, NULL) == EXACT_YES && adds_up(&e, row + i, &c), "row %d", i);
        exact_combination_clear(&c);
    }
    for (int j = 0; j < COLS; j++)
        CHECK(!e.mark[j], "column %d is left marked", j);
    exact_echelon_clear(&e);
    for (int i = 0; i < ROWS; i++)
        exact_row_clear(row + i);
    fmpz_mat_clear(m);
}

int main(void)
{
    flint_randinit(source);
    n_randlimb(source);
    for (unsigned long k = check_seed(5) % 1000; k; k--)
        n_randlimb(source);
    for (int k = 0, count = check_scale(300); k < count; k++) {
        combinations(k % 3, k % 5 == 0 ? 200 : 4);
        bases(k % 5 == 0 ? 200 : 4);
    }
    long_chain();
    for (int k = 0, count = check_scale(6); k < count; k++)
        wide_rows();
    flint_randclear(source);
    flint_cleanup();
    return CHECK_END();
}
