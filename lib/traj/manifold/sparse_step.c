/* Independent rows by elimination, the step by the stationarity system of these. */
#include "sparse_step.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "jacobian.h"
#include "lin_kkt.h"
#include "lin_sparse.h"
#include "mem.h"
#include "normal.h"
#include "sparse.h"
#include "watch.h"

/* Entries below this part of their row are none. */
static const double NOTHING = 1e-10;
/* A residual that no longer falls may be this large, in units. */
static const double STALLED = 1e-11;
/* Later steps together below this part of the first one: the constraints are nearly affine here. */
static const double EASY = 0.1;

void sparse_step_init(struct sparse_step *s, struct manifold *m, const double *unit)
{
    size_t n = (size_t)m->n, c = (size_t)m->c;
    *s = (struct sparse_step){ .m = m, .unit = unit };
    s->fixed = sga_calloc(n + 1, 1);
    s->held = sga_calloc(n + 1, sizeof *s->held);
    s->row = sga_malloc((2 * c + 1) * sizeof *s->row);
    s->before = s->row + c;
    s->value = sga_malloc(((size_t)m->jac->nnz + c + 1) * sizeof *s->value);
    s->r = s->value + m->jac->nnz;
}

void sparse_step_clear(struct sparse_step *s)
{
    free(s->fixed);
    free(s->held);
    free(s->row);
    free(s->value);
    lin_kkt_free(s->kkt);
}

static int ascending(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

/* Rows that are independent in the columns that move. */
static void choose_rows(struct sparse_step *s)
{
    struct manifold *m = s->m;
    struct points_row *row = sga_calloc((size_t)m->c + 1, sizeof *row);
    for (int i = 0; i < m->c; i++) {
        row[i].cap = m->cols[i];
        row[i].col = sga_malloc((size_t)(m->cols[i] + 1) * sizeof(int));
        row[i].val = sga_malloc((size_t)(m->cols[i] + 1) * sizeof(double));
        for (int k = 0; k < m->cols[i]; k++) {
            if (m->step->value[i][k] == 0)
                continue;
            row[i].col[row[i].len] = m->col[i][k];
            row[i].val[row[i].len++] = m->step->value[i][k];
        }
    }
    struct points_lu lu;
    points_lu_factor(&lu, row, m->c, m->n, NOTHING);
    s->rows = lu.rank;
    if (lu.rank)
        memcpy(s->row, lu.pivot_row, (size_t)lu.rank * sizeof *s->row);
    qsort(s->row, (size_t)s->rows, sizeof *s->row, ascending);
    points_lu_clear(&lu);
    for (int i = 1; i < s->rows; i++)
        assert(s->row[i - 1] < s->row[i]);       /* pivots have rows of their own */
}

/* The system for these rows, made anew where they are others than before. */
static void pattern(struct sparse_step *s)
{
    struct manifold *m = s->m;
    if (s->kkt && s->befores == s->rows && memcmp(s->before, s->row, (size_t)s->rows * sizeof *s->row) == 0)
        return;
    int *ptr = sga_calloc((size_t)s->rows + 1, sizeof *ptr), *col = sga_malloc(((size_t)m->jac->nnz + 1) * sizeof *col);
    for (int i = 0; i < s->rows; i++) {
        memcpy(col + ptr[i], m->col[s->row[i]], (size_t)m->cols[s->row[i]] * sizeof *col);
        ptr[i + 1] = ptr[i] + m->cols[s->row[i]];
    }
    struct lin_sparse *J = lin_sparse_new(s->rows, m->n, ptr, col);
    lin_kkt_free(s->kkt);
    s->kkt = lin_kkt_new(J);
    lin_sparse_free(J);
    memcpy(s->before, s->row, (size_t)s->rows * sizeof *s->row);
    s->befores = s->rows;
    free(ptr);
    free(col);
}

double sparse_step_find(struct sparse_step *s, double t, const double *x, const double *weight, const double *to, double *d, bool *ok)
{
    struct manifold *m = s->m;
    double worst = manifold_residual(m, t, x, s->unit, s->fixed);
    *ok = false;
    if (worst < 0)
        return -1;
    choose_rows(s);
    pattern(s);
    int at = 0;
    for (int i = 0; i < s->rows; i++) {
        const double *row = m->step->value[s->row[i]];
        for (int k = 0; k < m->cols[s->row[i]]; k++)
            s->value[at++] = row[k];
        s->r[i] = m->r[s->row[i]];
    }
    assert(at <= m->jac->nnz);
    for (int j = 0; j < m->n; j++)
        s->held[j] = s->fixed[j];
    *ok = lin_kkt_factor(s->kkt, s->value, weight, s->held);
    if (*ok)
        lin_kkt_solve(s->kkt, s->r, to, d);
    return worst;
}

static double move(const struct sparse_step *s, double *x, const double *d, double part)
{
    double sum = 0;
    for (int j = 0; j < s->m->n; j++)
        if (!s->fixed[j]) {
            x[j] += part * d[j] * s->unit[j];
            sum += part * part * d[j] * d[j];
        }
    return sqrt(sum);
}

bool sparse_step_settle(struct sparse_step *s, double t, double *x, const double *weight, int steps, bool *easy)
{
    enum { HALVES = 10 };
    size_t n = (size_t)s->m->n;
    double *y = memcpy(sga_malloc((2 * n + 1) * sizeof *y), x, n * sizeof *x), *d = y + n, last = INFINITY, first = -1, rest = 0;
    bool ok = false, more = true;
    for (int k = 0; more && sga_watch_ok(); k++) {
        bool step;
        double res = sparse_step_find(s, t, y, weight, NULL, d, &step), part = 1;
        ok = res >= 0 && (manifold_settled(s->m, y, s->unit, res) || (s->m->plain < STALLED && (k == steps || res >= 0.5 * last)));
        more = !ok && step && k < steps && res >= 0;
        if (!more)
            break;
        double length = move(s, y, d, 1);
        for (int half = 0; half < HALVES && sga_watch_ok(); half++, part /= 2) {
            double there = manifold_residual(s->m, t, y, s->unit, s->fixed);
            if (there >= 0 && there <= 4 * res)
                break;
            length = move(s, y, d, -part / 2);
        }
        first < 0 ? (first = length) : (rest += length);
        more = length > 0;
        last = res;
    }
    if (ok)
        memcpy(x, y, n * sizeof *x);
    if (easy)
        *easy = ok && rest <= EASY * first;
    free(y);
    return ok;
}
