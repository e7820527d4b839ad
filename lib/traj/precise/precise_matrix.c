/* The Newton matrix of the stages, factored in double. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "collocation.h"
#include "lin_lu.h"
#include "lin_sparse.h"
#include "lu.h"
#include "mem.h"
#include "precise_stages.h"

#define DENSE_ALWAYS 60        /* unknowns up to which it is dense */
#define DENSE_MOST 600         /* and where Jacobians are full */
#define FULL 0.2

struct stage_matrix {
    int n, s;
    const double *inverse;     /* of A */
    const struct lin_sparse *J;
    double *dense, *copy; int *perm;
    struct lin_sparse *pattern; struct lin_lu *lu; int *place;
};

static bool full(const struct lin_sparse *J)
{
    return (double)J->ptr[J->rows] > FULL * J->rows * J->rows;
}

int stage_matrix_most(const struct lin_sparse *J)
{
    return full(J) && J->rows > 0 ? DENSE_MOST / J->rows : NUM_RADAU_MOST;
}

/* Which entry of the sparse matrix belongs to which of A^-1 and of the blocks. */
static void make_pattern(struct stage_matrix *w)
{
    const struct lin_sparse *J = w->J;
    int n = w->n, s = w->s, nnz = J->ptr[n], count = s * s * n + s * nnz, k = 0;
    int *row = sga_malloc((size_t)count * sizeof *row), *col = sga_malloc((size_t)count * sizeof *col);
    for (int i = 0; i < s; i++)
        for (int j = 0; j < s; j++)
            for (int a = 0; a < n; a++, k++) {
                row[k] = i * n + a;
                col[k] = j * n + a;
            }
    for (int i = 0; i < s; i++)
        for (int a = 0; a < n; a++)
            for (int e = J->ptr[a]; e < J->ptr[a + 1]; e++, k++) {
                row[k] = i * n + a;
                col[k] = i * n + J->col[e];
            }
    assert(k == count);
    w->place = sga_malloc((size_t)count * sizeof *w->place);
    w->pattern = lin_sparse_from_entries(s * n, s * n, count, row, col, w->place);
    w->lu = lin_lu_new(w->pattern);
    free(row);
    free(col);
}

struct stage_matrix *stage_matrix_new(const struct num_radau *formula, const struct lin_sparse *J)
{
    struct stage_matrix *w = sga_calloc(1, sizeof *w);
    w->n = J->rows;
    w->s = formula->s;
    w->inverse = formula->inverse;
    w->J = J;
    size_t N = (size_t)w->s * (size_t)w->n;
    w->copy = sga_calloc(N + 1, sizeof *w->copy);
    if (full(J) || N <= DENSE_ALWAYS) {
        w->dense = sga_calloc(N * N + 1, sizeof *w->dense);
        w->perm = sga_calloc(N + 1, sizeof *w->perm);
    } else {
        make_pattern(w);
    }
    return w;
}

void stage_matrix_free(struct stage_matrix *w)
{
    if (!w)
        return;
    free(w->dense);
    free(w->copy);
    free(w->perm);
    free(w->place);
    lin_lu_free(w->lu);
    lin_sparse_free(w->pattern);
    free(w);
}

static bool factor_dense(struct stage_matrix *w, const double *K)
{
    const struct lin_sparse *J = w->J;
    int n = w->n, s = w->s, N = n * s;
    memset(w->dense, 0, (size_t)N * (size_t)N * sizeof *w->dense);
    for (int i = 0; i < s; i++)
        for (int a = 0; a < n; a++) {
            double *row = w->dense + (size_t)(i * n + a) * (size_t)N;
            for (int j = 0; j < s; j++)
                row[j * n + a] = w->inverse[i * s + j];
            for (int e = J->ptr[a]; e < J->ptr[a + 1]; e++)
                row[i * n + J->col[e]] -= K[i * J->ptr[n] + e];
        }
    return num_lu_factor(w->dense, w->perm, N);
}

bool stage_matrix_factor(struct stage_matrix *w, const double *K)
{
    if (w->dense)
        return factor_dense(w, K);
    int n = w->n, s = w->s, count = s * s * n;
    double *value = w->pattern->val;
    memset(value, 0, (size_t)w->pattern->ptr[s * n] * sizeof *value);
    for (int k = 0; k < count; k++)
        value[w->place[k]] += w->inverse[k / n];
    for (int k = 0; k < s * w->J->ptr[n]; k++)
        value[w->place[count + k]] -= K[k];
    return lin_lu_factor(w->lu, value);
}

void stage_matrix_solve(struct stage_matrix *w, double *r)
{
    int n = w->n, s = w->s;
    memset(w->copy, 0, (size_t)n * (size_t)s * sizeof *w->copy);
    for (int i = 0; i < s; i++)
        for (int k = 0; k < s; k++)
            for (int j = 0; j < n; j++)
                w->copy[i * n + j] += w->inverse[i * s + k] * r[k * n + j];
    if (w->dense) {
        num_lu_solve(w->dense, w->perm, n * s, w->copy, r);
    } else {
        lin_lu_solve(w->lu, w->copy);
        memcpy(r, w->copy, (size_t)n * (size_t)s * sizeof *r);
    }
}

double stage_matrix_cost(const struct stage_matrix *w)
{
    double N = (double)w->n * w->s;
    if (w->dense)
        return N * N * N / 3;
    double fill = lin_lu_counts(w->lu).fill;
    return 8 * fill + fill * fill / fmax(1, N);
}

double stage_matrix_solve_cost(const struct stage_matrix *w)
{
    double N = (double)w->n * w->s;
    return (double)w->s * N + (w->dense ? N * N : 2.0 * lin_lu_counts(w->lu).fill);
}
