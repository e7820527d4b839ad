/* Residuals and projections, sparse, in double. */
#include "manifold.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "jacobian.h"
#include "larger.h"
#include "mem.h"
#include "normal.h"
#include "reduction.h"
#include "system.h"
#include "tape.h"
#include "watch.h"

enum { CHORD_ROWS = 24 };

bool manifold_init(struct manifold *m, const struct sys_system *sys, const struct sga_solution *sol,
                   const struct num_switches *switches, struct sga_error *err)
{
    int n = sys->variables, c = sol->constraints;
    *m = (struct manifold){ .n = n, .c = c };
    int *inputs = sga_malloc((size_t)(n + 1) * sizeof *inputs);
    int *columns = sga_malloc((size_t)(n + 1) * sizeof *columns);
    expr_id *root = sga_malloc((size_t)(c + 1) * sizeof *root);
    for (int j = 0; j < n; j++) {
        inputs[j] = sys->variable[j].symbol;
        columns[j] = j;
    }
    inputs[n] = sys->time;
    for (int i = 0; i < c; i++)
        root[i] = sol->constraint[i].expr;
    m->tape = num_tape_new_switched(sys->store, switches, root, c, inputs, n + 1, err);
    if (m->tape)
        m->jac = num_jacobian_new(m->tape, columns, n);
    free(inputs);
    free(columns);
    free(root);
    if (!m->jac)
        return false;
    m->in = sga_calloc((size_t)n + 1, sizeof *m->in);
    m->r = sga_calloc((size_t)c + 1, sizeof *m->r);
    m->value = sga_calloc((size_t)m->jac->nnz + 1, sizeof *m->value);
    m->d = sga_calloc((size_t)n + 1, sizeof *m->d);
    m->big = sga_calloc((size_t)c + 1, sizeof *m->big);
    m->slope = sga_calloc((size_t)c + 1, sizeof *m->slope);
    m->shift = sga_calloc((size_t)n + 1, sizeof *m->shift);
    m->col = sga_calloc((size_t)c + 1, sizeof *m->col);
    m->cols = sga_calloc((size_t)c + 1, sizeof *m->cols);
    for (int i = 0; i < c; i++) {
        m->col[i] = m->jac->col + m->jac->start[i];
        m->cols[i] = m->jac->start[i + 1] - m->jac->start[i];
    }
    m->step = sga_calloc(1, sizeof *m->step);
    normal_init(m->step, c, n, m->col, m->cols);
    if (c > 0 && c <= CHORD_ROWS) {
        m->chord.factor = sga_calloc((size_t)c * (size_t)(c + 5), sizeof *m->chord.factor);
        m->chord.y = m->chord.factor + c * c;
        m->chord.most = m->chord.y + c;
        m->chord.least = m->chord.most + c;
        m->chord.sum_y = m->chord.least + c;
        m->chord.sum_r = m->chord.sum_y + c;
    }
    return true;
}

void manifold_clear(struct manifold *m)
{
    if (m->step)
        normal_clear(m->step);
    free(m->step);
    num_jacobian_free(m->jac);
    num_tape_free(m->tape);
    free(m->in);
    free(m->r);
    free(m->value);
    free(m->d);
    free(m->big);
    free(m->slope);
    free(m->shift);
    free(m->chord.factor);
    free(m->col);
    free(m->cols);
    *m = (struct manifold){ 0 };
}

/* A residual that no longer falls may be this large, in units of the variables. */
static const double STALLED = 1e-11;

/* Steps shorter than so many roundings of the largest variable leave the gradients as they are. */
static const double NEARBY = 1e9;

static void aim(struct manifold *m)
{
    for (int i = 0; i < m->c && m->target; i++)
        m->r[i] -= m->target[i];
}

double manifold_residual(struct manifold *m, double t, const double *x, const double *scale, const unsigned char *held)
{
    sga_copy(m->in, x, m->n);
    m->in[m->n] = t;
    if (!num_jacobian_eval(m->jac, m->in, m->r, m->value))
        return -1;
    double worst = 0;
    aim(m);
    m->raw = m->plain = 0;
    for (int i = 0; i < m->c; i++) {
        double big = 0, slope = 0, *row = m->step->value[i];
        const double *value = m->value + m->jac->start[i];
        m->raw = sga_larger(m->raw, fabs(m->r[i]));
        for (int k = 0; k < m->cols[i]; k++) {
            int j = m->col[i][k];
            double v = value[k] * (scale ? scale : m->unit)[j];
            slope = sga_larger(slope, fabs(value[k]) * m->unit[j]);
            big = sga_larger(big, fabs(v));
            row[k] = held && held[j] ? 0 : v;
        }
        if (!(big > 0)) {
            if (m->r[i] != 0)
                return -1;
            big = 1;
        }
        m->big[i] = big;
        m->slope[i] = slope > 0 ? slope : 1;
        m->plain = sga_larger(m->plain, fabs(m->r[i]) / m->slope[i]);
        m->r[i] /= big;
        for (int k = 0; k < m->cols[i]; k++)
            row[k] /= big;
        worst = sga_larger(worst, fabs(m->r[i]));
    }
    return worst;
}

/* The same after a small step, by the gradients from before it: enough to see that the end is reached. */
static double residual_nearby(struct manifold *m, const double *x)
{
    double worst = 0;
    for (int j = 0; j < m->n; j++)
        m->in[j] = x[j];
    if (!num_tape_eval(m->tape, m->in, m->r))
        return INFINITY;
    aim(m);
    m->raw = m->plain = 0;
    for (int i = 0; i < m->c; i++) {
        double r = fabs(m->r[i]);
        m->raw = sga_larger(m->raw, r);
        m->plain = sga_larger(m->plain, r / m->slope[i]);
        m->r[i] /= m->big[i];
        worst = sga_larger(worst, fabs(m->r[i]));
    }
    return worst;
}

static int worst_of(const struct manifold *m)
{
    int w = 0;
    for (int i = 1; i < m->c; i++)
        if (fabs(m->r[i]) > fabs(m->r[w]))
            w = i;
    return w;
}

/* Rounding level of a scaled residual at x. */
static double floor_of(const struct manifold *m, const double *x, const double *scale)
{
    double size = 1e-3;
    for (int j = 0; j < m->n; j++)
        size = sga_larger(size, fabs(x[j]) / (scale ? scale : m->unit)[j]);
    return MANIFOLD_ROUNDING * size;
}

bool manifold_settled(const struct manifold *m, const double *x, const double *scale, double residual)
{
    double floor = floor_of(m, x, scale);
    bool settled = residual <= floor;
    for (int i = 0; i < m->c && settled && floor > MANIFOLD_ROUNDING; i++) {
        double own = 1e-3;
        for (int k = 0; k < m->cols[i]; k++)
            own = sga_larger(own, fabs(m->value[m->jac->start[i] + k] * x[m->col[i][k]]) / m->big[i]);
        settled = fabs(m->r[i]) <= MANIFOLD_OWN * MANIFOLD_ROUNDING * own;
    }
    return settled;
}

/* x += damp * d in units of scale, held columns left; returns the scaled length. */
static double take_step(struct manifold *m, double *x, const double *scale, const unsigned char *held, double damp)
{
    double sum = 0;
    for (int j = 0; j < m->n; j++) {
        if (held && held[j])
            m->d[j] = 0;
        x[j] += damp * m->d[j] * (scale ? scale : m->unit)[j];
        sum += damp * damp * m->d[j] * m->d[j];
    }
    return sqrt(sum);
}

static void report(const struct manifold *m, double total, double res, double *moved, double *residual, int *worst)
{
    if (moved)
        *moved = total;
    if (residual)
        *residual = res;
    if (worst)
        *worst = m->c ? worst_of(m) : -1;
}

/* Small systems end soon, and need not look at the clock at each projection. */
static bool may_go_on(const struct manifold *m, int k)
{
    return (k < 2 && m->c <= CHORD_ROWS) || sga_watch_ok();
}

bool manifold_project(struct manifold *m, double t, double *x, const double *scale, const unsigned char *held,
                      int steps, double *moved, double *residual, int *worst)
{
    double total = 0, res = manifold_residual(m, t, x, scale, held), last = INFINITY;
    bool ok = false;
    for (int k = 0; res >= 0 && may_go_on(m, k); k++) {
        /* at rounding level, or as near to it as the conditioning lets it come */
        ok = manifold_settled(m, x, scale, res) || (m->plain < STALLED && (k == steps || res >= 0.5 * last));
        if (ok || k == steps)
            break;
        last = res;
        int rank = held && m->step->kkt ? normal_basic_step(m->step, m->r, m->d) : normal_quick_step(m->step, m->r, m->d);
        if (rank == 0)
            break;
        double damp = 1, length = take_step(m, x, scale, held, 1);
        double floor = floor_of(m, x, scale);
        if (length < NEARBY * floor && manifold_settled(m, x, scale, res = residual_nearby(m, x))) {
            total += length;
            ok = true;
            break;
        }
        res = manifold_residual(m, t, x, scale, held);
        for (int half = 0; half < 8 && (res < 0 || res > 4 * last) && may_go_on(m, k); half++) {
            length = take_step(m, x, scale, held, -damp / 2);     /* back by half of what was taken */
            damp /= 2;
            res = manifold_residual(m, t, x, scale, held);
        }
        total += length;
    }
    report(m, total, res, moved, residual, worst);
    assert(!ok || (res >= 0 && total >= 0));
    return ok;
}

bool manifold_walk(struct manifold *m, double t, double *x, const double *scale, const unsigned char *held,
                   double longest, int steps)
{
    for (int k = 0; k < steps && may_go_on(m, k); k++) {
        double res = manifold_residual(m, t, x, scale, held), big = 0;
        if (res < 0)
            return false;
        if (res < 1e-9)
            break;
        if (normal_step(m->step, m->r, m->d) == 0)
            return false;
        for (int j = 0; j < m->n; j++)
            big = fmax(big, fabs(m->d[j]));
        take_step(m, x, scale, held, big > longest ? longest / big : 1);
    }
    return manifold_project(m, t, x, scale, held, 20, NULL, NULL, NULL);
}

/* Each step goes to the point of the linearised set that is nearest to the guess:
 * J d = -r with |guess - x - d| least, that is d = shift + e with J e = -r - J shift and e
 * of least norm. It converges linearly where the set is curved; then one plain projection. */
bool manifold_nearest(struct manifold *m, double t, const double *to, double *x, const double *scale, const unsigned char *held,
                      int steps, double *moved, double *residual, int *worst)
{
    int n = m->n;
    double *guess = memcpy(sga_malloc((size_t)(n + 1) * sizeof *x), to ? to : x, (size_t)n * sizeof *x);
    double res = 0, length = INFINITY, before;
    bool ok = false;
    for (int k = 0; k < steps && may_go_on(m, k); k++) {
        res = manifold_residual(m, t, x, scale, held);
        if (res < 0)
            break;
        for (int j = 0; j < n; j++)
            m->shift[j] = held && held[j] ? 0 : (guess[j] - x[j]) / (scale ? scale : m->unit)[j];
        for (int i = 0; i < m->c; i++)
            for (int q = 0; q < m->cols[i]; q++)
                m->r[i] += m->step->value[i][q] * m->shift[m->col[i][q]];
        if (normal_step(m->step, m->r, m->d) == 0 && res > 1e-11)
            break;
        for (int j = 0; j < n; j++)
            m->d[j] += m->shift[j];
        before = length;
        length = take_step(m, x, scale, held, 1);
        /* what is left of a linear convergence may be more than its last step */
        ok = res < 1e-8 && length < 1e-12;
        if (ok || (k > 40 && length > 0.99 * before))
            break;
    }
    /* where the nearest point cannot be pinned down, a point of the set is still an answer */
    ok = manifold_project(m, t, x, scale, held, 60, NULL, residual, worst);
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += pow((x[j] - guess[j]) / (scale ? scale : m->unit)[j], 2);
    if (moved)
        *moved = sqrt(sum);
    free(guess);
    return ok;
}
