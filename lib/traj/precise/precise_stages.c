/* Newton's method for the stages of an implicit step, in double and then in double-double. */
#include "precise_stages.h"
#include "precise_series.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "collocation.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "jacobian.h"
#include "jet.h"
#include "lin_sparse.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "trajectory.h"

#define MOST_ITERATIONS 30
#define MOST_MATRICES 6        /* for one step, in the second part */
#define SOLVED 1e-3            /* of the error allowed may be left */
#define ROUNDING 16            /* roundings of a stage that a correction cannot fall below */
#define STALLED 0.1            /* of the error allowed: a correction that falls no more may be so large */
#define NOISE 1e-10            /* of the first one: and so large with new Jacobians too */
#define ROUGH_ITERATIONS 12
#define ROUGH 1e-9             /* relative: so far in double */
#define DIGITS 15.0            /* that are gained after the matrix is there */
#define FLOPS 6.0              /* multiplications in double in the time of one in double-double: measured */

struct precise_stages *precise_stages_new(struct precise_march *m, int s)
{
    struct precise_stages *w = sga_calloc(1, sizeof *w);
    struct precise *p = m->p;
    const struct lin_sparse *J = p->flow->field->pattern;
    int n = w->n = m->n;
    w->s = s;
    if (!p->values)
        p->values = num_jet2_new(p->flow->field->plain, 0);
    if (m->sides.count)
        precise_hold(m);
    if (!p->formula || p->formula->s != s) {
        num_radau_free(p->formula);
        p->formula = num_radau_new(s);
    }
    w->formula = p->formula;
    w->matrix = stage_matrix_new(w->formula, J);
    size_t N = (size_t)s * (size_t)n, ss = (size_t)s * (size_t)s;
    w->z = sga_calloc(2 * N + 1, sizeof *w->z);
    w->f = w->z + N;
    w->unit = sga_calloc(3 * (size_t)n + 1 + 2 * N + (size_t)s * (size_t)J->ptr[n] + 4 * ss, sizeof *w->unit);
    w->noise = w->unit + n;
    w->in = w->noise + n;
    w->residual = w->in + n + 1;
    w->rough = w->residual + N;
    w->split.a = w->rough + N;
    w->split.lo = w->split.a + ss;
    w->split.head = w->split.lo + ss;
    w->split.tail = w->split.head + ss;
    w->jac = w->split.tail + ss;
    for (size_t k = 0; k < ss; k++) {
        double a = w->formula->A[k].hi, c = 134217729.0 * a;       /* 2^27 + 1 */
        w->split.a[k] = a;
        w->split.lo[k] = w->formula->A[k].lo;
        w->split.head[k] = c - (c - a);
        w->split.tail[k] = a - w->split.head[k];
    }
    return w;
}

void precise_stages_free(struct precise_stages *w)
{
    if (!w)
        return;
    stage_matrix_free(w->matrix);
    free(w->z);
    free(w->unit);
    free(w);
}

/* The field at every stage. */
static bool evaluate(struct precise_stages *w, struct precise_march *m, num_dd h)
{
    struct num_jet2 *jet = m->p->values;
    int n = w->n;
    w->work += 4.0 * w->s * num_jet2_length(jet);
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

/* sum_k a_ik f_kj, as if in twice double precision and then rounded (Ogita, Rump, Oishi: Dot2). The halves of A are
 * at hand, those of f are made on the way. */
static num_dd row_times(const struct precise_stages *w, int i, const double (*part)[4])
{
    const double *a = w->split.a + i * w->s, *lo = w->split.lo + i * w->s;
    const double *head = w->split.head + i * w->s, *tail = w->split.tail + i * w->s;
    double sum = 0, rest = 0;
    for (int k = 0; k < w->s; k++) {
        double p = a[k] * part[k][0];
        double low = ((head[k] * part[k][2] - p) + head[k] * part[k][3] + tail[k] * part[k][2]) + tail[k] * part[k][3];
        double t = sum + p, v = t - sum;
        rest += (sum - (t - v)) + (p - v);
        rest += low + (a[k] * part[k][1] + lo[k] * part[k][0]);
        sum = t;
    }
    return num_dd_fast_two_sum(sum, rest);
}

/* w->residual = z - h A f in units. */
static void residuals(struct precise_stages *w, num_dd h)
{
    int n = w->n, s = w->s;
    double part[NUM_RADAU_MOST][4];
    w->work += (double)s * s * n;
    for (int j = 0; j < n; j++) {
        for (int k = 0; k < s; k++) {
            num_dd f = w->f[k * n + j];
            double c = 134217729.0 * f.hi;
            part[k][0] = f.hi;
            part[k][1] = f.lo;
            part[k][2] = c - (c - f.hi);
            part[k][3] = f.hi - part[k][2];
        }
        for (int i = 0; i < s; i++) {
            num_dd sum = row_times(w, i, (const double (*)[4])part);
            w->residual[i * n + j] = num_dd_sub(w->z[i * n + j], num_dd_mul(h, sum)).hi / w->unit[j];
        }
    }
}

/* w->jac and, where field is not NULL, the field (s x n) at x + z (s x n) in double. */
static bool linearise(struct precise_stages *w, struct precise_march *m, num_dd h, const double *z, double *field)
{
    struct field *f = m->p->flow->field;
    int n = w->n, nnz = f->pattern->ptr[n];
    w->work += (double)w->s * (4.0 * num_jet2_length(m->p->values) + 2 * nnz) / FLOPS;
    for (int i = 0; i < w->s; i++) {
        double *value = w->jac + (size_t)i * (size_t)nnz;
        for (int j = 0; j < n; j++)
            w->in[j] = m->here.x[j].hi + z[i * n + j];
        w->in[n] = m->here.t.hi + w->formula->c[i].hi * h.hi;
        if (!num_jacobian_eval(f->slope, w->in, field ? field + i * n : NULL, value))
            return false;
        for (int a = 0; a < n; a++)
            for (int e = f->pattern->ptr[a]; e < f->pattern->ptr[a + 1]; e++)
                value[e] *= h.hi * (w->unit[f->pattern->col[e]] / w->unit[a]);
    }
    return true;
}

/* Relative corrections this small change the Jacobians so little that iterations with the old matrix, which gain as
 * many digits as the corrections are small, take less than a new one and the few with it. */
static double small_enough(const struct precise_stages *w, const struct precise_march *m)
{
    double s = w->s, iteration = stage_matrix_solve_cost(w->matrix) + FLOPS * s * (s * w->n + 4.0 * num_jet2_length(m->p->values));
    return pow(10, -DIGITS / (1.7 + stage_matrix_cost(w->matrix) / iteration));
}

static bool factor(struct precise_stages *w, const struct precise_march *m)
{
    struct sga_error ignored = { 0 };
    w->factored = sga_budget_ok(m->p->rq->budget, &ignored) && stage_matrix_factor(w->matrix, w->jac);
    w->work += stage_matrix_cost(w->matrix) / FLOPS;
    return w->factored;
}

/* w->residual becomes the Newton correction; its size in units, root mean square. */
static double correction(struct precise_stages *w)
{
    double sum = 0;
    int N = w->n * w->s;
    assert(w->factored);
    stage_matrix_solve(w->matrix, w->residual);
    w->work += stage_matrix_solve_cost(w->matrix) / FLOPS;
    for (int k = 0; k < N; k++)
        sum += w->residual[k] * w->residual[k];
    return N ? sqrt(sum / N) : 0;
}

/* The size of the stages in units, root mean square. */
static double size_of_stages(const struct precise_stages *w, const struct precise_march *m)
{
    double sum = 0;
    for (int j = 0; j < w->n; j++) {
        double most = fabs(m->here.x[j].hi);
        for (int i = 0; i < w->s; i++)
            most = fmax(most, fabs(m->here.x[j].hi + w->z[i * w->n + j].hi));
        sum += pow(most / w->unit[j], 2);
    }
    return w->n ? sqrt(sum / w->n) : 0;
}

/* The largest correction against the size of its variable over the stages. */
static double relative(const struct precise_stages *w, const struct precise_march *m, const double *z)
{
    double worst = 0;
    for (int j = 0; j < w->n; j++) {
        double size = fabs(m->here.x[j].hi), move = 0;
        for (int i = 0; i < w->s; i++) {
            size = fmax(size, fabs(m->here.x[j].hi + z[i * w->n + j]));
            move = fmax(move, fabs(w->residual[i * w->n + j]) * w->unit[j]);
        }
        worst = fmax(worst, move / fmax(size, w->unit[j] / ROUGH));
    }
    return worst;
}

/* In double from the guess on: most of the way where that goes far. The matrix of the end is factored. */
static enum precise_solved solve_roughly(struct precise_stages *w, struct precise_march *m, num_dd h)
{
    int n = w->n, s = w->s, N = n * s, grown = 0;
    double before = INFINITY, field[NUM_RADAU_MOST], *z = w->rough, *f = w->residual;
    bool same = false;
    for (int k = 0; k < N; k++)
        z[k] = w->z[k].hi;
    for (int k = 0; k < ROUGH_ITERATIONS; k++) {
        if (!linearise(w, m, h, z, f))
            return STAGES_REFUSED;
        if (!same && !factor(w, m))
            return STAGES_DIVERGED;
        w->work += (double)s * N / FLOPS;
        for (int j = 0; j < n; j++) {
            for (int i = 0; i < s; i++)
                field[i] = f[i * n + j];
            for (int i = 0; i < s; i++) {
                double sum = 0;
                for (int q = 0; q < s; q++)
                    sum += w->split.a[i * s + q] * field[q];
                f[i * n + j] = (z[i * n + j] - h.hi * sum) / w->unit[j];
            }
        }
        double size = correction(w);
        if (!isfinite(size) || ((grown += size > 2 * before) > 1))
            return STAGES_DIVERGED;
        for (int i = 0; i < N; i++)
            z[i] -= w->residual[i] * w->unit[i % n];
        double part = relative(w, m, z);
        if (part <= ROUGH || (k > 2 && size > 0.5 * before))
            break;
        double enough = small_enough(w, m);
        same = part <= enough && !(k && size > 10 * enough * before);
        before = size;
    }
    for (int k = 0; k < N; k++)
        w->z[k] = num_dd_of(z[k]);
    return STAGES_SOLVED;
}

/* Corrections that fall no more are what rounding in the field makes of them. */
static void take_noise(struct precise_stages *w)
{
    for (int k = 0; k < w->n * w->s; k++)
        w->noise[k % w->n] = fmax(w->noise[k % w->n], fabs(w->residual[k]) * w->unit[k % w->n]);
}

enum precise_solved precise_stages_solve(struct precise_stages *w, struct precise_march *m, num_dd h)
{
    int matrices = 0, N = w->n * w->s;
    double before = 0, first = 0;
    memset(w->noise, 0, (size_t)w->n * sizeof *w->noise);
    memcpy(w->unit, m->scale, (size_t)w->n * sizeof *w->unit);
    w->factored = false;
    enum precise_solved rough = solve_roughly(w, m, h);
    if (rough != STAGES_SOLVED)
        return rough;
    for (int k = 0; k < MOST_ITERATIONS; k++) {
        if (!evaluate(w, m, h))
            return STAGES_REFUSED;
        if (!w->factored) {
            for (int i = 0; i < N; i++)
                w->rough[i] = w->z[i].hi;
            matrices++;
            if (!linearise(w, m, h, w->rough, NULL))
                return STAGES_REFUSED;
            if (!factor(w, m))
                return STAGES_DIVERGED;
        }
        residuals(w, h);
        double size = correction(w), rate = k ? size / before : 1;
        if (!isfinite(size))
            return STAGES_DIVERGED;
        for (int i = 0; i < N; i++)
            w->z[i] = num_dd_add_d(w->z[i], -w->residual[i] * w->unit[i % w->n]);
        first = k ? first : size;
        if (size <= ROUNDING * NUM_DD_EPSILON * size_of_stages(w, m) || (k && rate < 1 && size * rate / (1 - rate) <= SOLVED))
            return STAGES_SOLVED;
        if (k && rate > 0.5 && (size <= STALLED || (matrices && size <= NOISE * first))) {
            take_noise(w);
            return STAGES_SOLVED;
        }
        if (k && (rate > 2 || (rate > 0.9 && matrices == MOST_MATRICES)))
            return STAGES_DIVERGED;
        w->factored = !k || rate <= 10 * small_enough(w, m) || matrices == MOST_MATRICES;
        before = size;
    }
    return STAGES_DIVERGED;
}
