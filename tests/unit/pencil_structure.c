/* Kronecker structure: pencils built from a known canonical form by random changes of basis come
 * back exactly; so do their transposes (right and left exchanged) and scaled ones. */
#include <string.h>

#include <flint/fmpq_mat.h>

#include "check.h"
#include "error.h"
#include "mem.h"
#include "pencil.h"

enum { MOST = 24 };

/* What a canonical form is made of. Finite blocks: (den s - num)^size, or (s^2 + 2 or so)^size. */
struct form {
    int right[MOST], rights, left[MOST], lefts, infinite[MOST], infinites;
    struct { int poly, size; } block[MOST];
    int blocks;
};

/* Irreducible, pairwise coprime. */
static const int poly_table[][3] = {
    { 0, 1, 0 }, { -1, 1, 0 }, { 3, 2, 0 }, { -7, 3, 0 }, { 2, 0, 1 }, { 1, 1, 1 }, { -2, 0, 1 }
};
enum { POLYS = sizeof poly_table / sizeof *poly_table };

static int degree(int poly)
{
    return poly_table[poly][2] ? 2 : 1;
}

static int unproved;            /* answers by the way without a proof */
static unsigned long random_state;
static int below(int n)
{
    random_state = random_state * 6364136223846793005UL + 1442695040888963407UL;
    return (int)((random_state >> 33) % (unsigned long)n);
}

static int ascending(const void *x, const void *y)
{
    return *(const int *)x - *(const int *)y;
}
static int descending(const void *x, const void *y)
{
    return *(const int *)y - *(const int *)x;
}

static struct form random_form(int most)
{
    struct form f = { .rights = below(3), .lefts = below(3), .infinites = below(4), .blocks = below(6) };
    for (int i = 0; i < f.rights; i++)
        f.right[i] = below(most);
    for (int i = 0; i < f.lefts; i++)
        f.left[i] = below(most);
    for (int i = 0; i < f.infinites; i++)
        f.infinite[i] = 1 + below(most);
    for (int i = 0; i < f.blocks; i++) {
        f.block[i].poly = below(below(2) ? 2 : POLYS);
        f.block[i].size = 1 + below(3);
    }
    qsort(f.right, (size_t)f.rights, sizeof *f.right, ascending);
    qsort(f.left, (size_t)f.lefts, sizeof *f.left, ascending);
    qsort(f.infinite, (size_t)f.infinites, sizeof *f.infinite, descending);
    return f;
}

static void size_of(const struct form *f, int *rows, int *cols)
{
    *rows = *cols = 0;
    for (int i = 0; i < f->rights; i++)
        *rows += f->right[i], *cols += f->right[i] + 1;
    for (int i = 0; i < f->lefts; i++)
        *rows += f->left[i] + 1, *cols += f->left[i];
    for (int i = 0; i < f->infinites; i++)
        *rows += f->infinite[i], *cols += f->infinite[i];
    for (int i = 0; i < f->blocks; i++)
        *rows += f->block[i].size * degree(f->block[i].poly), *cols += f->block[i].size * degree(f->block[i].poly);
}

static void put(fmpq_mat_t m, int i, int j, long v)
{
    fmpq_set_si(fmpq_mat_entry(m, i, j), v, 1);
}

/* Blocks on the diagonal. A finite block: chain of companion pencils. */
static void canonical(const struct form *f, fmpq_mat_t A, fmpq_mat_t B)
{
    int r = 0, c = 0;
    for (int i = 0; i < f->rights; r += f->right[i], c += f->right[i] + 1, i++)
        for (int k = 0; k < f->right[i]; k++)
            put(A, r + k, c + k, 1), put(B, r + k, c + k + 1, 1);
    for (int i = 0; i < f->lefts; r += f->left[i] + 1, c += f->left[i], i++)
        for (int k = 0; k < f->left[i]; k++)
            put(A, r + k, c + k, 1), put(B, r + k + 1, c + k, 1);
    for (int i = 0; i < f->infinites; r += f->infinite[i], c += f->infinite[i], i++)
        for (int k = 0; k < f->infinite[i]; k++) {
            put(B, r + k, c + k, 1);
            if (k + 1 < f->infinite[i])
                put(A, r + k, c + k + 1, 1);
        }
    for (int i = 0; i < f->blocks; i++) {
        const int *p = poly_table[f->block[i].poly];
        int d = degree(f->block[i].poly);
        for (int k = 0; k < f->block[i].size; k++, r += d, c += d) {
            if (d == 1) {
                put(A, r, c, p[1]), put(B, r, c, -p[0]);
            } else {
                put(A, r, c, 1), put(B, r, c + 1, 1);
                put(A, r + 1, c + 1, p[2]), put(B, r + 1, c, -p[0]), put(B, r + 1, c + 1, -p[1]);
            }
            if (k + 1 < f->block[i].size)
                put(B, r + d - 1, c + d, 1);
        }
    }
}

static void random_regular(fmpq_mat_t m)
{
    fmpq_t det;
    fmpq_init(det);
    do {
        for (int i = 0; i < fmpq_mat_nrows(m); i++)
            for (int j = 0; j < fmpq_mat_ncols(m); j++)
                fmpq_set_si(fmpq_mat_entry(m, i, j), below(3) ? below(7) - 3 : 0, (ulong)(1 + below(2)));
        fmpq_mat_det(det, m);
    } while (fmpq_is_zero(det));
    fmpq_clear(det);
}

static void fill(struct pencil *p, const fmpq_mat_t A, const fmpq_mat_t B, bool transpose)
{
    int m = (int)fmpq_mat_nrows(A), n = (int)fmpq_mat_ncols(A);
    pencil_init(p, transpose ? n : m, transpose ? m : n);
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++) {
            pencil_add(&p->A, transpose ? j : i, transpose ? i : j, fmpq_mat_entry(A, i, j));
            pencil_add(&p->B, transpose ? j : i, transpose ? i : j, fmpq_mat_entry(B, i, j));
        }
}

static bool same(const int *a, int na, const int *b, int nb)
{
    return na == nb && (na == 0 || memcmp(a, b, (size_t)na * sizeof *a) == 0);
}

/* The factor of s that poly divides, or NULL. */
static const struct pencil_factor *factor_of(const struct pencil_structure *s, int poly)
{
    const struct pencil_factor *found = NULL;
    fmpz_poly_t f, q;
    fmpz_poly_init(f);
    fmpz_poly_init(q);
    for (int k = 0; k < 3; k++)
        fmpz_poly_set_coeff_si(f, k, poly_table[poly][k]);
    for (int i = 0; i < s->factors; i++)
        if (fmpz_poly_divides(q, s->factor[i].f, f))
            found = s->factor + i;
    fmpz_poly_clear(f);
    fmpz_poly_clear(q);
    return found;
}

static void check_finite(const struct form *f, const struct pencil_structure *s)
{
    int total = 0, counted = 0;
    for (int poly = 0; poly < POLYS; poly++) {
        int size[MOST], n = 0, sum = 0;
        for (int i = 0; i < f->blocks; i++)
            if (f->block[i].poly == poly)
                sum += size[n++] = f->block[i].size;
        const struct pencil_factor *p = factor_of(s, poly);
        CHECK((p != NULL) == (n > 0), "poly %d", poly);
        if (!p || !n)
            continue;
        qsort(size, (size_t)n, sizeof *size, descending);
        CHECK(p->multiplicity == sum, "%d, not %d", p->multiplicity, sum);
        CHECK(same(p->block, p->blocks, size, n), "poly %d: %d blocks, first %d", poly, p->blocks, p->block[0]);
        total += sum * degree(poly);
    }
    for (int i = 0; i < s->factors; i++)
        counted += s->factor[i].multiplicity * (int)fmpz_poly_degree(s->factor[i].f);
    CHECK(s->finite == total && counted == total, "%d %d %d", s->finite, counted, total);
}

static void check_form(const struct form *f, const struct pencil *p, bool transpose, double max_work)
{
    struct pencil_structure s;
    struct sga_error err = { 0 };
    struct pencil_options o = { .spectrum = true, .max_work = max_work };
    int rows, cols;
    size_of(f, &rows, &cols);
    CHECK(pencil_structure(p, &o, &s, &err), "%s", err.detail);
    const int *right = transpose ? f->left : f->right, *left = transpose ? f->right : f->left;
    int rights = transpose ? f->lefts : f->rights, lefts = transpose ? f->rights : f->lefts;
    CHECK(same(s.right, s.rights, right, rights));
    CHECK(same(s.left, s.lefts, left, lefts));
    CHECK(same(s.infinite, s.infinites, f->infinite, f->infinites));
    CHECK(s.nilpotency == (f->infinites ? f->infinite[0] : 0));
    CHECK(s.normal_rank == cols - f->rights);
    CHECK(s.regular == (!f->rights && !f->lefts));
    CHECK(max_work > 0 || s.basis == PENCIL_PROVED);
    unproved += s.basis == PENCIL_MODULAR;
    check_finite(f, &s);
    pencil_structure_clear(&s);
}

static void test_form(const struct form *f)
{
    int rows, cols;
    fmpq_mat_t A, B, P, Q;
    struct pencil p;
    size_of(f, &rows, &cols);
    fmpq_mat_init(A, rows, cols);
    fmpq_mat_init(B, rows, cols);
    fmpq_mat_init(P, rows, rows);
    fmpq_mat_init(Q, cols, cols);
    canonical(f, A, B);
    fill(&p, A, B, false);
    check_form(f, &p, false, 0);
    pencil_clear(&p);
    random_regular(P);
    random_regular(Q);
    fmpq_mat_mul(A, P, A);
    fmpq_mat_mul(A, A, Q);
    fmpq_mat_mul(B, P, B);
    fmpq_mat_mul(B, B, Q);
    for (int transpose = 0; transpose < 2; transpose++) {
        fill(&p, A, B, transpose);
        check_form(f, &p, transpose, 0);
        if (rows > 4)
            check_form(f, &p, transpose, 1e-9);
        pencil_clear(&p);
    }
    fmpq_mat_clear(A);
    fmpq_mat_clear(B);
    fmpq_mat_clear(P);
    fmpq_mat_clear(Q);
}

int main(void)
{
    random_state = check_seed(20260401);
    for (int i = 0, n = check_scale(60); i < n; i++) {
        struct form f = random_form(4);
        test_form(&f);
    }
    struct form large = { .right = { 5 }, .rights = 1, .left = { 0, 6 }, .lefts = 2, .infinite = { 7, 7, 2, 1 }, .infinites = 4,
                          .block = { { 1, 5 }, { 1, 4 }, { 1, 2 }, { 1, 1 } }, .blocks = 4 };
    test_form(&large);
    struct form empty = { .rights = 0 }, column = { .rights = 2 }, row = { .lefts = 1 };
    test_form(&empty);
    test_form(&column);
    test_form(&row);
    struct form pair = { .block = { { 4, 2 }, { 4, 2 }, { 5, 3 }, { 5, 1 }, { 6, 1 } }, .blocks = 5 };
    test_form(&pair);
    CHECK(unproved > check_scale(60) / 6, "%d", unproved);
    return CHECK_END();
}
