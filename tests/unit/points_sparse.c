/* Sparse elimination: ranks, and solves with small residuals, of matrices that fill (a flow in a cavity and its rates) and of random ones;
 * and that columns which become no pivots are left out where they would be most of the work. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "check.h"
#include "sparse.h"

struct matrix {
    int rows, cols;
    struct points_row *row;
};

static double between(uint64_t *seed, double a, double b)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return a + (b - a) * (double)(*seed >> 11) * 0x1p-53;
}

static void add(struct points_row *r, int col, double v)
{
    for (int k = 0; k < r->len; k++)
        if (r->col[k] == col) {
            r->val[k] += v;
            return;
        }
    if (r->len == r->cap) {
        r->cap = r->cap ? 2 * r->cap : 8;
        r->col = realloc(r->col, (size_t)r->cap * sizeof *r->col);
        r->val = realloc(r->val, (size_t)r->cap * sizeof *r->val);
    }
    r->col[r->len] = col;
    r->val[r->len++] = v;
}

/* An elimination takes its rows. */
static struct matrix copy(const struct matrix *m)
{
    struct matrix to = { m->rows, m->cols, calloc((size_t)m->rows, sizeof *to.row) };
    for (int i = 0; i < m->rows; i++)
        for (int k = 0; k < m->row[i].len; k++)
            add(to.row + i, m->row[i].col[k], m->row[i].val[k]);
    return to;
}

static void matrix_free(struct matrix *m)
{
    for (int i = 0; i < m->rows; i++) {
        free(m->row[i].col);
        free(m->row[i].val);
    }
    free(m->row);
}

/* Velocities on the inner faces of n x n cells, then pressures: -1 where there is none. */
static int face_u(int n, int r, int c)
{
    return r >= 0 && r < n && c > 0 && c < n ? r * (n - 1) + c - 1 : -1;
}

static int face_v(int n, int r, int c)
{
    return r > 0 && r < n && c >= 0 && c < n ? n * (n - 1) + (r - 1) * n + c : -1;
}

/* f times the rate of a velocity: a sum over its neighbours, and the two pressures beside it. */
static void add_rate(struct points_row *row, int n, bool across, int r, int c, double f)
{
    int (*face)(int, int, int) = across ? face_u : face_v, at = face(n, r, c), p = 2 * n * (n - 1);
    if (at < 0)
        return;
    const int step[4][2] = { { 0, 1 }, { 0, -1 }, { 1, 0 }, { -1, 0 } };
    for (int k = 0; k < 4; k++)
        if (face(n, r + step[k][0], c + step[k][1]) >= 0)
            add(row, face(n, r + step[k][0], c + step[k][1]), f);
    add(row, at, -4 * f);
    add(row, p + r * n + c, -f);
    add(row, p + (across ? r * n + c - 1 : (r - 1) * n + c), f);
}

/* No flow out of a cell, and the rate of that: of each kind one row follows from the others; `less` rows of each are left out. */
static struct matrix flow(int n, int less)
{
    int each = n * n - less;
    struct matrix m = { 2 * each, 2 * n * (n - 1) + n * n, calloc((size_t)(2 * each), sizeof *m.row) };
    for (int i = 0; i < each; i++) {
        int r = i / n, c = i % n;
        const struct { bool across; int r, c; double sign; } side[4] = { { true, r, c + 1, 1 }, { true, r, c, -1 }, { false, r + 1, c, 1 }, { false, r, c, -1 } };
        for (int k = 0; k < 4; k++) {
            int at = side[k].across ? face_u(n, side[k].r, side[k].c) : face_v(n, side[k].r, side[k].c);
            if (at >= 0)
                add(m.row + i, at, side[k].sign);
            add_rate(m.row + each + i, n, side[k].across, side[k].r, side[k].c, side[k].sign);
        }
    }
    return m;
}

static struct matrix scattered(uint64_t *seed, int rows, int cols, int entries)
{
    struct matrix m = { rows, cols, calloc((size_t)rows, sizeof *m.row) };
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < entries; k++)
            add(m.row + i, (int)between(seed, 0, cols), between(seed, -1, 1));
    return m;
}

/* The elimination of m has this rank, and solves m x = m (random). Returns the entries of its U and operations. */
static double solves(struct matrix *m, int rank, const char *what)
{
    struct matrix to = copy(m);
    struct points_lu lu;
    points_lu_factor(&lu, to.row, m->rows, m->cols, 1e-10);
    CHECK(lu.rank == rank, "rank %d of %s, not %d", lu.rank, what, rank);
    double *x = calloc((size_t)m->cols, sizeof *x), *b = calloc((size_t)m->rows, sizeof *b), *right = calloc((size_t)m->rows, sizeof *right), off = 0, size = 1;
    unsigned char *row_seen = calloc((size_t)m->rows, 1), *col_seen = calloc((size_t)m->cols, 1);
    uint64_t seed = 5;
    for (int j = 0; j < m->cols; j++)
        x[j] = between(&seed, -1, 1);
    for (int i = 0; i < m->rows; i++)
        for (int k = 0; k < m->row[i].len; k++)
            right[i] += m->row[i].val[k] * x[m->row[i].col[k]];
    for (int i = 0; i < m->rows; i++)
        b[i] = right[i];
    for (int j = 0; j < m->cols; j++)
        x[j] = 0;
    points_lu_solve(&lu, b, x);
    double entries = lu.ops;
    for (int s = 0; s < lu.rank; s++) {
        CHECK(!row_seen[lu.pivot_row[s]] && !col_seen[lu.pivot_col[s]], "a row or column twice in %s", what);
        row_seen[lu.pivot_row[s]] = col_seen[lu.pivot_col[s]] = 1;
        entries += lu.row[lu.pivot_row[s]].len;
    }
    for (int j = 0; j < m->cols; j++) {
        CHECK(col_seen[j] || x[j] == 0, "column %d of %s is no pivot and not 0", j, what);
        size = fmax(size, fabs(x[j]));
    }
    for (int i = 0; i < m->rows; i++) {
        double sum = -right[i];
        for (int k = 0; k < m->row[i].len; k++)
            sum += m->row[i].val[k] * x[m->row[i].col[k]];
        off = fmax(off, fabs(sum));
    }
    CHECK(off < 1e-11 * size, "residual %g of %s, where x is %g", off, what, size);
    points_lu_clear(&lu);
    free(x);
    free(b);
    free(right);
    free(row_seen);
    free(col_seen);
    return entries;
}

int main(void)
{
    const int n = 60;
    struct matrix m = flow(n, 1);
    double given = 0, entries = solves(&m, m.rows, "a flow");
    for (int i = 0; i < m.rows; i++)
        given += m.row[i].len;
    CHECK(entries < 10 * given, "%g entries in the factors, of %g", entries, given);
    matrix_free(&m);
    m = flow(n, 0);
    solves(&m, m.rows - 2, "a flow with two dependent rows");
    matrix_free(&m);
    uint64_t seed = 3;
    m = flow(n, 1);                 /* columns that are a guess are nearly dependent */
    for (int i = 0; i < m.rows; i++)
        for (int k = 0; k < m.row[i].len; k++)
            m.row[i].val[k] *= pow(10, between(&seed, -4, 0));
    solves(&m, m.rows, "a flow of many sizes");
    matrix_free(&m);
    for (int k = 0; k < 6; k++) {
        int rows = 100 + 100 * k;
        m = scattered(&seed, rows, rows + rows / 2, 20);
        solves(&m, rows, "a random matrix");
        struct points_row *last = m.row + rows - 1;       /* a combination of others */
        last->len = 0;
        for (int i = 0; i < 3; i++)
            for (int e = 0; e < m.row[7 * i].len; e++)
                add(last, m.row[7 * i].col[e], (i + 1) * m.row[7 * i].val[e]);
        m.row[3].len = 0;
        solves(&m, rows - 2, "a random matrix with a dependent row and an empty one");
        matrix_free(&m);
    }
    return CHECK_END();
}
