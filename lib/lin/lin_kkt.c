/* Corrections of least weighted norm by the stationarity system; see the header. */
#include "lin_kkt.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "lin_lu.h"
#include "lin_sparse.h"
#include "mem.h"

/* Below this ratio of pivots the condition of J is looked at itself. */
#define SUSPICIOUS_PIVOTS 1e-8
/* Below this condition of J the system is formed anew with a smaller alpha. */
#define ILL_CONDITIONED 1e-5
/* Rows count as dependent below this. */
#define SINGULAR 1e-13
/* Larger systems are ordered as symmetric ones: the matching of smaller ones tells ill conditions better, but costs a power of the fill.
 * Their pivots are as small as J's singular values, and another alpha costs their order of elimination, so that it is taken later; what
 * is lost by that is made up by one step of refinement more. */
enum { LARGE = 500 };
#define LARGE_SUSPICIOUS 1e-8
#define LARGE_ILL_CONDITIONED 1e-9

/* A factorisation fills where it takes MUCH multiplications, some hundredths of a second, and MUCH_EACH for each entry: a plane grid of
 * 100,000 nodes takes some 1,000 for each, four thousand constraints across a random graph 6,000. */
static const double MUCH = 2e7, MUCH_EACH = 4000;

struct lin_kkt {
    struct sga_arena mem;
    int c, n;
    struct lin_sparse *J;     /* pattern, and scaled values D J W^-1 */
    struct lin_sparse *K;     /* the stationarity system's pattern and values */
    int *upper, *lower;       /* [entry of J]: its two places in K */
    struct lin_lu *lu;
    double *unit;             /* n: 1/w, and 0 where held */
    double *row;              /* c: D */
    double *v;                /* 3 (n + c): right-hand side and solution, and for refining */
    double alpha;
    double rcond;             /* < 0: not known yet */
    bool regular, large;
};

static struct lin_sparse *kkt_pattern(struct lin_kkt *k)
{
    const struct lin_sparse *J = k->J;
    int n = k->n, c = k->c, nz = J->ptr[c];
    int count = n + 2 * nz, at = 0;
    SGA_ARENA(mem);
    int *row = sga_take(&mem, ((size_t)count + 1) * sizeof *row);
    int *col = sga_take(&mem, ((size_t)count + 1) * sizeof *col);
    int *place = sga_take(&mem, ((size_t)count + 1) * sizeof *place);
    for (int j = 0; j < n; j++, at++)
        row[at] = col[at] = j;
    for (int i = 0; i < c; i++)
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++, at += 2) {
            row[at] = col[at + 1] = J->col[e];
            col[at] = row[at + 1] = n + i;
        }
    struct lin_sparse *K = lin_sparse_from_entries(n + c, n + c, count, row, col, place);
    for (int e = 0; e < nz; e++) {
        k->upper[e] = place[n + 2 * e];
        k->lower[e] = place[n + 2 * e + 1];
    }
    return K;
}

struct lin_kkt *lin_kkt_new(const struct lin_sparse *J)
{
    struct lin_kkt *k = sga_calloc(1, sizeof *k);
    k->c = J->rows;
    k->n = J->cols;
    k->J = lin_sparse_new(J->rows, J->cols, J->ptr, J->col);
    size_t nz = (size_t)J->ptr[J->rows] + 1;
    k->upper = sga_take(&k->mem, nz * sizeof *k->upper);
    k->lower = sga_take(&k->mem, nz * sizeof *k->lower);
    k->K = kkt_pattern(k);
    k->large = k->c + k->n > LARGE;
    k->lu = k->large ? lin_lu_new_symmetric(k->K) : lin_lu_new(k->K);
    k->unit = sga_zeros(&k->mem, (size_t)k->n + 1, sizeof *k->unit);
    k->row = sga_zeros(&k->mem, (size_t)k->c + 1, sizeof *k->row);
    k->v = sga_zeros(&k->mem, 3 * ((size_t)k->n + (size_t)k->c) + 1, sizeof *k->v);
    return k;
}

bool lin_kkt_fills(const struct lin_kkt *k)
{
    double work = lin_lu_foretold(k->lu);
    return work > MUCH && work > MUCH_EACH * (double)k->K->ptr[k->c + k->n];
}

void lin_kkt_free(struct lin_kkt *k)
{
    if (!k)
        return;
    lin_lu_free(k->lu);
    lin_sparse_free(k->K);
    lin_sparse_free(k->J);
    sga_arena_end(&k->mem);
    free(k);
}

static bool set_units(struct lin_kkt *k, const double *w, const bool *held)
{
    for (int j = 0; j < k->n; j++) {
        double wj = w ? w[j] : 1;
        if (!(wj > 0) || !isfinite(wj) || !isfinite(1 / wj))
            return false;
        k->unit[j] = held && held[j] ? 0 : 1 / wj;
    }
    return true;
}

/* J's values become D J W^-1 with rows of norm 1. False: not finite, or a row is 0. The
 * largest entry is taken out first, so that squares neither overflow nor vanish. */
static bool set_scaled(struct lin_kkt *k, const double *val)
{
    struct lin_sparse *J = k->J;
    for (int i = 0; i < k->c; i++) {
        double largest = 0, sum = 0;
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++) {
            J->val[e] = val[e] * k->unit[J->col[e]];
            if (!isfinite(J->val[e]))
                return false;
            largest = fmax(largest, fabs(J->val[e]));
        }
        if (!(largest > 0))
            return false;
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++)
            sum += (J->val[e] / largest) * (J->val[e] / largest);
        double norm = largest * sqrt(sum);
        if (!isfinite(norm) || !isfinite(1 / norm))
            return false;
        k->row[i] = 1 / norm;
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++)
            J->val[e] *= k->row[i];
    }
    return true;
}

static bool factor_with(struct lin_kkt *k, double alpha)
{
    k->alpha = alpha;
    memset(k->K->val, 0, (size_t)k->K->ptr[k->n + k->c] * sizeof *k->K->val);
    for (int j = 0; j < k->n; j++)
        k->K->val[k->K->ptr[j]] = alpha;   /* the diagonal is first in its row */
    for (int e = 0; e < k->J->ptr[k->c]; e++)
        k->K->val[k->upper[e]] = k->K->val[k->lower[e]] = k->J->val[e];
    return lin_lu_factor(k->lu, k->K->val);
}

static double normalise(int n, double *v)
{
    double s = 0;
    for (int i = 0; i < n; i++)
        s += v[i] * v[i];
    s = sqrt(s);
    for (int i = 0; i < n && s > 0; i++)
        v[i] /= s;
    return s;
}

/* Largest singular value of the scaled J: power iteration on J J^T from v (c). */
static double largest_singular(const struct lin_kkt *k, double *v)
{
    SGA_FREED double *u = sga_malloc(((size_t)k->n + 1) * sizeof *u);
    double s = 0;
    for (int turn = 0; turn < 4; turn++) {
        lin_sparse_transpose_times(k->J, v, u);
        s = 0;
        for (int j = 0; j < k->n; j++)
            s += u[j] * u[j];
        lin_sparse_times(k->J, u, v);
        normalise(k->c, v);
    }
    return sqrt(s);
}

/* Smallest singular value: solving with (0, v) gives y = J^+ v, so |y| tends to
 * 1/sigma_min, and mu = -alpha (J J^T)^-1 v, the next v. */
static double smallest_singular(struct lin_kkt *k, double *v)
{
    double sigma = 1;
    for (int turn = 0; turn < 4; turn++) {
        memset(k->v, 0, (size_t)k->n * sizeof *k->v);
        memcpy(k->v + k->n, v, (size_t)k->c * sizeof *v);
        lin_lu_solve(k->lu, k->v);
        double norm = normalise(k->n, k->v);
        if (!(norm > 0) || !isfinite(norm))
            return 0;
        sigma = 1 / norm;
        memcpy(v, k->v + k->n, (size_t)k->c * sizeof *v);
        normalise(k->c, v);
        if (!lin_all_finite(k->c, v))
            return 0;
    }
    return sigma;
}

/* Some vector of norm 1 that is not special to any J. */
static void start_vector(int n, double *v)
{
    unsigned long state = 12345;
    for (int i = 0; i < n; i++) {
        state = state * 6364136223846793005ul + 1442695040888963407ul;
        v[i] = 0.5 + (double)(state >> 40) / (1 << 24);
        v[i] *= state >> 33 & 1 ? 1 : -1;
    }
    normalise(n, v);
}

static double condition(struct lin_kkt *k)
{
    if (k->c == 0)
        return 1;
    SGA_FREED double *v = sga_malloc((size_t)k->c * sizeof *v);
    start_vector(k->c, v);
    double large = largest_singular(k, v);
    start_vector(k->c, v);
    double small = smallest_singular(k, v);
    /* rows of norm 1 bound the largest singular value from below */
    return small > 0 ? fmin(1, small / fmax(large, 1)) : 0;
}

bool lin_kkt_factor(struct lin_kkt *k, const double *val, const double *w, const bool *held)
{
    k->regular = false;
    k->rcond = 0;
    if (!set_units(k, w, held) || !set_scaled(k, val) || !factor_with(k, 1))
        return false;
    k->rcond = -1;
    if (lin_lu_rcond_crude(k->lu) < (k->large ? LARGE_SUSPICIOUS : SUSPICIOUS_PIVOTS)) {
        k->rcond = condition(k);
        if (k->rcond > 0 && k->rcond < (k->large ? LARGE_ILL_CONDITIONED : ILL_CONDITIONED)) {
            if (!factor_with(k, fmax(k->rcond, 1e-10))) {
                k->rcond = 0;
                return false;
            }
            k->rcond = condition(k);
        }
        if (k->rcond < SINGULAR)
            return false;
    }
    k->regular = true;
    return true;
}

/* v becomes K^-1 v, with a step of refinement, or two: it makes the conditions hold to the
 * rounding of their terms also where the weights make K ill-conditioned. */
static void solve_refined(struct lin_kkt *k)
{
    int size = k->n + k->c;
    double *b = k->v, *x = k->v + size, *rest = x + size;
    memcpy(x, b, (size_t)size * sizeof *b);
    lin_lu_solve(k->lu, x);
    for (int turn = k->large ? 2 : 1; turn > 0; turn--) {
        lin_sparse_times(k->K, x, rest);
        for (int i = 0; i < size; i++)
            rest[i] = b[i] - rest[i];
        lin_lu_solve(k->lu, rest);
        for (int i = 0; i < size; i++)
            x[i] += rest[i];
    }
    memcpy(b, x, (size_t)size * sizeof *b);
}

void lin_kkt_solve(struct lin_kkt *k, const double *r, const double *g, double *d)
{
    assert(k->regular);
    for (int j = 0; j < k->n; j++)
        k->v[j] = g && k->unit[j] > 0 ? k->alpha * g[j] / k->unit[j] : 0;
    for (int i = 0; i < k->c; i++)
        k->v[k->n + i] = -r[i] * k->row[i];
    solve_refined(k);
    for (int j = 0; j < k->n; j++)
        d[j] = k->v[j] * k->unit[j];
}

double lin_kkt_rcond(struct lin_kkt *k)
{
    if (k->rcond < 0)
        k->rcond = condition(k);
    return k->rcond;
}

struct lin_lu_counts lin_kkt_counts(const struct lin_kkt *k)
{
    return lin_lu_counts(k->lu);
}
