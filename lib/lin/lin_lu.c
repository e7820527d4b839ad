/* Square sparse systems by KLU.
 *
 * KLU takes compressed columns. It is given our rows as they are, that is A^T, and
 * solves with the transpose: no entry has to be moved. */
#include "lin_lu.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/klu.h>

#include "lin_sparse.h"
#include "mem.h"

/* Pivots are kept while the entries of U stay below this many times those of A, or
 * below this many times what they were with fresh pivots. */
#define LARGEST_GROWTH 1e3

/* A diagonal entry is the pivot where it is so large beside its column: without a matching it may be small, or 0 (KLU's own is 1e-3). Each
 * other one costs the symmetry of what is left, and fills. So small ones are taken first, and all is done again where entries grew by
 * that; where nothing but zeros is left, other pivots leave the same. */
static const double SYMMETRIC_PIVOT = 0.1, SYMMETRIC_FIRST = 1e-8, FIRST_GROWTH = 1e3;

struct lin_lu {
    int n;
    struct lin_sparse *a;   /* the pattern, and the values last factored */
    klu_common common;
    klu_symbolic *symbolic;
    klu_numeric *numeric;
    bool symmetric;
    double fresh_growth;    /* KLU's reciprocal pivot growth when pivots were fresh */
    bool regular;           /* numeric holds a usable factorisation */
    struct lin_lu_counts counts;
};

static struct lin_lu *new(const struct lin_sparse *pattern, bool blocks)
{
    assert(pattern->rows == pattern->cols);
    struct lin_lu *lu = sga_calloc(1, sizeof *lu);
    lu->n = pattern->rows;
    lu->a = lin_sparse_new(lu->n, lu->n, pattern->ptr, pattern->col);
    klu_defaults(&lu->common);
    lu->common.btf = blocks;
    lu->symmetric = !blocks;
    if (lu->n > 0)
        lu->symbolic = klu_analyze(lu->n, lu->a->ptr, lu->a->col, &lu->common);
    assert(lu->n == 0 || lu->common.status != KLU_INVALID);
    return lu;
}

struct lin_lu *lin_lu_new(const struct lin_sparse *pattern)
{
    return new(pattern, true);
}

struct lin_lu *lin_lu_new_symmetric(const struct lin_sparse *pattern)
{
    return new(pattern, false);
}

void lin_lu_free(struct lin_lu *lu)
{
    if (!lu)
        return;
    if (lu->numeric)
        klu_free_numeric(&lu->numeric, &lu->common);
    if (lu->symbolic)
        klu_free_symbolic(&lu->symbolic, &lu->common);
    lin_sparse_free(lu->a);
    free(lu);
}

static bool factor_with_old_pivots(struct lin_lu *lu)
{
    struct lin_sparse *a = lu->a;
    if (!klu_refactor(a->ptr, a->col, a->val, lu->symbolic, lu->numeric, &lu->common) ||
        lu->common.status != KLU_OK)
        return false;
    if (!klu_rgrowth(a->ptr, a->col, a->val, lu->symbolic, lu->numeric, &lu->common))
        return false;
    if (!(lu->common.rgrowth * LARGEST_GROWTH > fmin(1, lu->fresh_growth)))
        return false;
    lu->counts.reused++;
    return true;
}

/* With these common parameters. */
static bool factor_as_set(struct lin_lu *lu)
{
    struct lin_sparse *a = lu->a;
    if (lu->numeric)
        klu_free_numeric(&lu->numeric, &lu->common);
    lu->numeric = klu_factor(a->ptr, a->col, a->val, lu->symbolic, &lu->common);
    lu->counts.fresh++;
    if (!lu->numeric || lu->common.status != KLU_OK)
        return false;
    klu_rgrowth(a->ptr, a->col, a->val, lu->symbolic, lu->numeric, &lu->common);
    lu->fresh_growth = lu->common.rgrowth;
    return true;
}

static bool factor_afresh(struct lin_lu *lu)
{
    bool ok;
    if (lu->symmetric) {
        lu->common.tol = SYMMETRIC_FIRST;
        ok = factor_as_set(lu);
        lu->common.tol = SYMMETRIC_PIVOT;
        if (ok && !(lu->fresh_growth * FIRST_GROWTH > 1))
            ok = factor_as_set(lu);
    } else
        ok = factor_as_set(lu);
    if (!ok)
        return false;
    lu->counts.fill = lu->numeric->lnz + lu->numeric->unz + lu->numeric->nzoff;
    return true;
}

bool lin_lu_factor(struct lin_lu *lu, const double *val)
{
    lu->regular = lu->n == 0;
    if (lu->n == 0)
        return true;
    int count = lu->a->ptr[lu->n];
    if (!lu->symbolic || !lin_all_finite(count, val))
        return false;
    if (count)
        memcpy(lu->a->val, val, (size_t)count * sizeof *val);
    lu->regular = (lu->numeric && factor_with_old_pivots(lu)) || factor_afresh(lu);
    return lu->regular;
}

double lin_lu_foretold(const struct lin_lu *lu)
{
    return lu->symbolic ? fmax(lu->symbolic->est_flops, 0) : 0;
}

double lin_lu_rcond_crude(const struct lin_lu *lu)
{
    if (lu->n == 0)
        return 1;
    klu_common common = lu->common;
    if (!lu->regular || !klu_rcond(lu->symbolic, lu->numeric, &common))
        return 0;
    return common.rcond;
}

double lin_lu_rcond(struct lin_lu *lu)
{
    if (lu->n == 0)
        return 1;
    if (!lu->regular ||
        !klu_condest(lu->a->ptr, lu->a->val, lu->symbolic, lu->numeric, &lu->common))
        return 0;
    return lu->common.condest > 0 ? 1 / lu->common.condest : 0;
}

void lin_lu_solve(struct lin_lu *lu, double *b)
{
    assert(lu->regular);
    if (lu->n > 0)
        klu_tsolve(lu->symbolic, lu->numeric, lu->n, 1, b, &lu->common);
}

void lin_lu_solve_transposed(struct lin_lu *lu, double *b)
{
    assert(lu->regular);
    if (lu->n > 0)
        klu_solve(lu->symbolic, lu->numeric, lu->n, 1, b, &lu->common);
}

struct lin_lu_counts lin_lu_counts(const struct lin_lu *lu)
{
    return lu->counts;
}

static int parity(const int *p, int n)
{
    unsigned char *seen = sga_calloc((size_t)n + 1, 1);
    int sign = 1;
    for (int i = 0; i < n; i++)
        for (int j = i, length = 0; !seen[j]; j = p[j], length++) {
            seen[j] = 1;
            sign = length > 0 ? -sign : sign;
        }
    free(seen);
    return sign;
}

int lin_lu_sign(const struct lin_lu *lu)
{
    int sign = 1;
    if (lu->n == 0)
        return sign;
    const double *d = lu->numeric->Udiag;
    for (int i = 0; i < lu->n; i++)
        sign = d[i] < 0 ? -sign : sign;
    return sign * parity(lu->numeric->Pnum, lu->n) * parity(lu->symbolic->Q, lu->n);
}
