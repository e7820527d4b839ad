/* Newton's method for the stages of an implicit step in double-double. */
#include "precise_stages.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lu.h"
#include "mem.h"

#define MOST_ITERATIONS 40
#define MOST_FACTORED 10       /* matrices for one step */
#define NEW_JACOBIANS 0.02     /* from this rate on they are taken anew */
#define SOLVED 1e-3            /* of the error allowed may be left */
#define ROUNDING 16            /* roundings of a stage that a correction cannot fall below */
#define STALLED 0.1            /* of the error allowed: a correction that falls no more may be so large */
#define DENSE_ALWAYS 60        /* unknowns of the matrix, up to which it is dense */
#define DENSE_MOST 600
#define FLOPS 12.0             /* double multiplications in the time of one in double-double */

/* The matrix is sparse: which entry of it belongs to which of A^-1 and of the Jacobians. */
static void make_pattern(struct precise_stages *w, const struct lin_sparse *J)
{
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
    w->place = sga_malloc((size_t)count * sizeof *w->place);
    w->pattern = lin_sparse_from_entries(s * n, s * n, count, row, col, w->place);
    w->lu = lin_lu_new(w->pattern);
    free(row);
    free(col);
}

struct precise_stages *precise_stages_new(struct precise_march *m, int s)
{
    struct precise_stages *w = sga_calloc(1, sizeof *w);
    struct precise *p = m->p;
    const struct lin_sparse *J = p->flow->field.pattern;
    int n = w->n = m->n;
    bool full = (double)J->ptr[n] > 0.4 * n * n;
    while (full && s > 3 && s * n > DENSE_MOST)
        s--;
    if (!p->values)
        p->values = num_jet2_new(p->flow->field.plain, 0);
    if (!p->formula || p->formula->s != s) {
        num_radau_free(p->formula);
        p->formula = num_radau_new(s);
    }
    w->s = s;
    w->formula = p->formula;
    size_t N = (size_t)s * (size_t)n, entries = (size_t)J->ptr[n];
    w->z = sga_calloc(2 * N + 1, sizeof *w->z);
    w->f = w->z + N;
    w->unit = sga_calloc((size_t)n + 2 * N + (size_t)s * entries + 1, sizeof *w->unit);
    w->residual = w->unit + n;
    w->rhs = w->residual + N;
    w->jac = w->rhs + N;
    if (full || N <= DENSE_ALWAYS) {
        w->dense = sga_calloc(N * N + 1, sizeof *w->dense);
        w->perm = sga_calloc(N + 1, sizeof *w->perm);
    } else {
        make_pattern(w, J);
    }
    return w;
}

void precise_stages_free(struct precise_stages *w)
{
    if (!w)
        return;
    free(w->z);
    free(w->unit);
    free(w->dense);
    free(w->perm);
    free(w->place);
    lin_lu_free(w->lu);
    lin_sparse_free(w->pattern);
    free(w);
}

/* The field at every stage. */
static bool evaluate(struct precise_stages *w, struct precise_march *m, num_dd h)
{
    struct num_jet2 *jet = m->p->values;
    int n = w->n;
    w->work += 2.5 * w->s * num_jet2_length(jet);
    m->path->evaluations += w->s;
    for (int i = 0; i < w->s; i++) {
        num_dd *z = w->z + i * n, *f = w->f + i * n;
        for (int j = 0; j < n; j++)
            num_jet2_input(jet, j)[0] = num_dd_add(m->here.x[j], z[j]);
        num_jet2_input(jet, n)[0] = num_dd_add(m->here.t, num_dd_mul(w->formula->c[i], h));
        if (!num_jet2_next(jet, 0))
            return false;
        for (int j = 0; j < n; j++) {
            f[j] = num_jet2_root(jet, j)[0];
            if (m->beside)
                f[j] = num_dd_mul(f[j], (num_dd){ 1, j % 2 ? -NUM_DD_EPSILON : NUM_DD_EPSILON });
        }
    }
    return true;
}

/* w->residual = z - h A f in units. */
static void residuals(struct precise_stages *w, num_dd h)
{
    int n = w->n, s = w->s;
    w->work += (double)s * s * n;
    for (int i = 0; i < s; i++)
        for (int j = 0; j < n; j++) {
            num_dd sum = num_dd_of(0);
            for (int k = 0; k < s; k++)
                sum = num_dd_add(sum, num_dd_mul(w->formula->A[i * s + k], w->f[k * n + j]));
            w->residual[i * n + j] = num_dd_sub(w->z[i * n + j], num_dd_mul(h, sum)).hi / w->unit[j];
        }
}

static bool jacobians(struct precise_stages *w, struct precise_march *m, num_dd h)
{
    struct field *f = &m->p->flow->field;
    int n = w->n, nnz = f->pattern->ptr[n];
    w->work += (double)w->s * (4.0 * num_jet2_length(m->p->values) + nnz) / FLOPS;
    for (int i = 0; i < w->s; i++) {
        double *value = w->jac + (size_t)i * (size_t)nnz;
        for (int j = 0; j < n; j++)
            m->xd[j] = m->here.x[j].hi + w->z[i * n + j].hi;
        if (!field_slope(f, m->here.t.hi + w->formula->c[i].hi * h.hi, m->xd, value))
            return false;
        for (int a = 0; a < n; a++)
            for (int e = f->pattern->ptr[a]; e < f->pattern->ptr[a + 1]; e++)
                value[e] *= -h.hi * (w->unit[f->pattern->col[e]] / w->unit[a]);
    }
    return true;
}

static bool factor_dense(struct precise_stages *w, const struct lin_sparse *J)
{
    int n = w->n, s = w->s, N = n * s;
    memset(w->dense, 0, (size_t)N * (size_t)N * sizeof *w->dense);
    for (int i = 0; i < s; i++)
        for (int a = 0; a < n; a++) {
            double *row = w->dense + (size_t)(i * n + a) * (size_t)N;
            for (int j = 0; j < s; j++)
                row[j * n + a] = w->formula->inverse[i * s + j];
            for (int e = J->ptr[a]; e < J->ptr[a + 1]; e++)
                row[i * n + J->col[e]] += w->jac[i * J->ptr[n] + e];
        }
    w->work += pow(N, 3) / 3 / FLOPS;
    return num_lu_factor(w->dense, w->perm, N);
}

static bool factor_sparse(struct precise_stages *w, const struct lin_sparse *J)
{
    int n = w->n, s = w->s, count = s * s * n;
    double *value = w->pattern->val;
    memset(value, 0, (size_t)w->pattern->ptr[s * n] * sizeof *value);
    for (int k = 0; k < count; k++)
        value[w->place[k]] += w->formula->inverse[k / n];
    for (int k = 0; k < s * J->ptr[n]; k++)
        value[w->place[count + k]] += w->jac[k];
    bool ok = lin_lu_factor(w->lu, value);
    double fill = lin_lu_counts(w->lu).fill;
    w->work += fill * fill / (s * n) / FLOPS;
    return ok;
}

/* z moves by the Newton correction; its size in units, root mean square. */
static double correct(struct precise_stages *w)
{
    int n = w->n, s = w->s, N = n * s;
    double *d = w->residual, sum = 0;
    for (int i = 0; i < s; i++)
        for (int j = 0; j < n; j++) {
            double v = 0;
            for (int k = 0; k < s; k++)
                v += w->formula->inverse[i * s + k] * w->residual[k * n + j];
            w->rhs[i * n + j] = v;
        }
    if (w->dense) {
        num_lu_solve(w->dense, w->perm, N, w->rhs, d);
        w->work += (double)N * N / FLOPS;
    } else {
        lin_lu_solve(w->lu, d = w->rhs);
        w->work += 2.0 * lin_lu_counts(w->lu).fill / FLOPS;
    }
    for (int k = 0; k < N; k++) {
        w->z[k] = num_dd_add_d(w->z[k], -d[k] * w->unit[k % n]);
        sum += d[k] * d[k];
    }
    return sqrt(sum / N);
}

/* What rounding leaves of a correction, in units. */
static double rounding(const struct precise_stages *w, const struct precise_march *m)
{
    double sum = 0;
    for (int j = 0; j < w->n; j++) {
        double most = 0;
        for (int i = 0; i < w->s; i++)
            most = fmax(most, fabs(m->here.x[j].hi + w->z[i * w->n + j].hi));
        sum += pow(most / w->unit[j], 2);
    }
    return ROUNDING * NUM_DD_EPSILON * sqrt(sum / w->n);
}

enum precise_solved precise_stages_solve(struct precise_stages *w, struct precise_march *m, num_dd h)
{
    const struct lin_sparse *J = m->p->flow->field.pattern;
    bool factored = false;
    int matrices = 0;
    double before = 0;
    memcpy(w->unit, m->scale, (size_t)w->n * sizeof *w->unit);
    for (int k = 0; k < MOST_ITERATIONS; k++) {
        struct sga_error ignored = { 0 };
        if (!evaluate(w, m, h))
            return STAGES_REFUSED;
        residuals(w, h);
        if (!factored) {
            if (!sga_budget_ok(m->p->rq->budget, &ignored))
                return STAGES_DIVERGED;
            if (!jacobians(w, m, h))
                return STAGES_REFUSED;
            matrices++;
            if (!(w->dense ? factor_dense(w, J) : factor_sparse(w, J)))
                return STAGES_DIVERGED;
            factored = true;
        }
        double size = correct(w), rate = k ? size / before : 1;
        if (!isfinite(size))
            return STAGES_DIVERGED;
        if (size <= rounding(w, m) || (k && ((rate < 1 && size * rate / (1 - rate) <= SOLVED) || (rate > 0.5 && size <= STALLED))))
            return STAGES_SOLVED;
        if (k && (rate > 2 || (rate > 0.9 && matrices == MOST_FACTORED)))
            return STAGES_DIVERGED;
        factored = !k || rate < NEW_JACOBIANS || matrices == MOST_FACTORED;
        before = size;
    }
    return STAGES_DIVERGED;
}
