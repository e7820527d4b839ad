/* Dense solutions of least norm by GSL's SVD. */
#include "lin_dense.h"

#include <float.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "lin_sparse.h"
#include "mem.h"

/* A = U S V^T with A tall; a wide matrix is stored transposed, and U and V trade places. */
struct svd {
    int p, q;               /* p >= q: shape of what is stored */
    bool transposed;
    gsl_matrix *u, *v;      /* p x q, q x q */
    gsl_vector *s;
};

static void svd_free(struct svd *f)
{
    gsl_matrix_free(f->u);
    gsl_matrix_free(f->v);
    gsl_vector_free(f->s);
}

static void svd_load(struct svd *f, const struct lin_dense *A)
{
    for (int i = 0; i < A->rows; i++)
        for (int j = 0; j < A->cols; j++) {
            double a = A->a[(size_t)i * (size_t)A->cols + (size_t)j];
            gsl_matrix_set(f->u, (size_t)(f->transposed ? j : i),
                           (size_t)(f->transposed ? i : j), a);
        }
}

/* A must have a row and a column. False leaves nothing to free. */
static bool svd_make(struct svd *f, const struct lin_dense *A)
{
    f->transposed = A->rows < A->cols;
    f->p = f->transposed ? A->cols : A->rows;
    f->q = f->transposed ? A->rows : A->cols;
    if (!lin_all_finite(A->rows * A->cols, A->a))
        return false;
    f->u = gsl_matrix_alloc((size_t)f->p, (size_t)f->q);
    f->v = gsl_matrix_alloc((size_t)f->q, (size_t)f->q);
    f->s = gsl_vector_alloc((size_t)f->q);
    gsl_vector *work = gsl_vector_alloc((size_t)f->q);
    bool ok = f->u && f->v && f->s && work;
    if (ok) {
        svd_load(f, A);
        ok = gsl_linalg_SV_decomp(f->u, f->v, f->s, work) == GSL_SUCCESS;
        if (!ok) {
            svd_load(f, A);
            ok = gsl_linalg_SV_decomp_jacobi(f->u, f->v, f->s) == GSL_SUCCESS;
        }
        ok = ok && lin_all_finite(f->q, f->s->data);
    }
    gsl_vector_free(work);
    if (!ok)
        svd_free(f);
    return ok;
}

static int svd_rank(const struct svd *f, double rtol, struct lin_least *out)
{
    int rank = 0;
    double top = gsl_vector_get(f->s, 0);
    double cut = (rtol > 0 ? rtol : f->p * DBL_EPSILON) * top;
    while (rank < f->q && gsl_vector_get(f->s, (size_t)rank) > cut)
        rank++;
    out->rank = rank;
    out->largest = top;
    out->smallest_kept = rank ? gsl_vector_get(f->s, (size_t)rank - 1) : 0;
    out->largest_dropped = rank < f->q ? gsl_vector_get(f->s, (size_t)rank) : 0;
    return rank;
}

static double left(const struct svd *f, int i, int k)
{
    return gsl_matrix_get(f->transposed ? f->v : f->u, (size_t)i, (size_t)k);
}

static double right(const struct svd *f, int j, int k)
{
    return gsl_matrix_get(f->transposed ? f->u : f->v, (size_t)j, (size_t)k);
}

static double residual(const struct lin_dense *A, const double *b, const double *x)
{
    double sum = 0;
    for (int i = 0; i < A->rows; i++) {
        double s = -b[i];
        for (int j = 0; j < A->cols; j++)
            s += A->a[(size_t)i * (size_t)A->cols + (size_t)j] * x[j];
        sum = hypot(sum, s);
    }
    return sum;
}

bool lin_least_norm(const struct lin_dense *A, const double *b, double rtol, double *x,
                    struct lin_least *out)
{
    struct lin_least mine;
    struct svd f;
    if (!out)
        out = &mine;
    *out = (struct lin_least){0};
    for (int j = 0; j < A->cols; j++)
        x[j] = 0;
    if (!lin_all_finite(A->rows, b))
        return false;
    if (A->rows > 0 && A->cols > 0) {
        if (!svd_make(&f, A))
            return false;
        int rank = svd_rank(&f, rtol, out);
        for (int k = 0; k < rank; k++) {
            double s = 0;
            for (int i = 0; i < A->rows; i++)
                s += left(&f, i, k) * b[i];
            s /= gsl_vector_get(f.s, (size_t)k);
            for (int j = 0; j < A->cols; j++)
                x[j] += s * right(&f, j, k);
        }
        svd_free(&f);
    }
    out->residual = residual(A, b, x);
    return true;
}

/* The i-th condition on y = W (d - g): entries of D J W^-1 into a, right side returned. */
static double scaled_row(const struct lin_correction *p, int i, double *a)
{
    const struct lin_sparse *J = p->J;
    double b = -p->r[i], norm = 0;
    for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++) {
        int j = J->col[e];
        if (p->held && p->held[j])
            continue;
        a[j] = J->val[e] / (p->w ? p->w[j] : 1);
        norm = hypot(norm, a[j]);
        if (p->g)
            b -= J->val[e] * p->g[j];
    }
    if (!(norm > 0))
        return b;
    for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++)
        a[J->col[e]] /= norm;
    return b / norm;
}

bool lin_correction_dense(const struct lin_correction *p, double rtol, double *d,
                          struct lin_least *out)
{
    int c = p->J->rows, n = p->J->cols;
    SGA_ARENA(mem);
    double *a = sga_zeros(&mem, (size_t)c * (size_t)n + 1, sizeof *a);
    double *b = sga_zeros(&mem, (size_t)c + 1, sizeof *b);
    for (int i = 0; i < c; i++)
        b[i] = scaled_row(p, i, a + (size_t)i * (size_t)n);
    struct lin_dense A = {c, n, a};
    bool ok = lin_least_norm(&A, b, rtol, d, out);
    for (int j = 0; j < n; j++) {
        if (p->held && p->held[j])
            d[j] = 0;
        else
            d[j] = d[j] / (p->w ? p->w[j] : 1) + (p->g && ok ? p->g[j] : 0);
    }
    return ok;
}
