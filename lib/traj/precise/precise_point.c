/* Points of the final set in double-double: projection, and the consistent start. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "flow.h"
#include "jacobian.h"
#include "kinds.h"
#include "manifold.h"
#include "mem.h"
#include "nearest.h"
#include "normal.h"
#include "precise.h"
#include "sizes.h"
#include "system.h"
#include "tangent.h"
#include "tape.h"
#include "tiers.h"

#define STEPS 12
/* A residual that no longer falls may be this large against what it is of. */
#define STALLED 1e-26
#define NEAREST_STEPS 60
/* A step so short may be as long as the one before. */
#define SMALL_STEP 1e-25
/* More constraints than this are not solved for in dense double-double. */
#define DENSE_MOST 200
/* Pivots of J J^T this much below the first one are dependent rows. */
#define DEPENDENT 1e-22

bool precise_residuals(struct precise *p, num_dd t, const num_dd *x, int order)
{
    for (int j = 0; j < p->n; j++)
        num_jet2_input(p->constraint, j)[0] = x[j];
    num_jet2_input(p->constraint, p->n)[0] = t;
    bool ok = true;
    for (int k = 0; k <= order; k++)
        ok &= num_jet2_next(p->constraint, k);
    return ok;
}

/* The double Jacobian at x, rows scaled as manifold_residual leaves them, and the residuals in
 * double-double over the same scales: the largest, or -1. m->r holds them. */
static double linearise(struct precise *p, num_dd t, const num_dd *x, double *xd, const double *scale,
                        const unsigned char *held, double *raw)
{
    struct manifold *m = p->flow->manifold;
    for (int j = 0; j < p->n; j++)
        xd[j] = x[j].hi;
    if (manifold_residual(m, t.hi, xd, scale, held) < 0 || !precise_residuals(p, t, x, 0))
        return -1;
    double worst = 0;
    *raw = 0;
    for (int i = 0; i < m->c; i++) {
        double big = 0;
        for (int k = 0; k < m->cols[i]; k++)
            big = fmax(big, fabs(m->value[m->jac->start[i] + k]) * (scale ? scale : m->unit)[m->col[i][k]]);
        double r = num_jet2_root(p->constraint, i)[0].hi;
        *raw = fmax(*raw, fabs(r));
        m->r[i] = big > 0 ? r / big : r;
        worst = fmax(worst, fabs(m->r[i]));
    }
    return worst;
}

/* What rounding leaves of a residual, in units of scale. */
static double rounding(const struct precise *p, const num_dd *x, const double *scale)
{
    double size = 1e-3;
    for (int j = 0; j < p->n; j++)
        size = fmax(size, fabs(x[j].hi) / (scale ? scale : p->flow->manifold->unit)[j]);
    return 2 * NUM_DD_EPSILON * size;
}

/* The residuals, as linearise left them at (t, xd), are what rounding of the time leaves: of sin t beside 1/4 that is more than of small variables. */
static bool within_time(struct precise *p, num_dd t, const double *xd)
{
    static const double MOVE = 0x1p-24, ROUNDINGS = 64;
    struct manifold *m = p->flow->manifold;
    SGA_FREED double *at = sga_malloc((2 * (size_t)m->c + 1) * sizeof *at);
    double *moved = at + m->c;
    memcpy(m->in, xd, (size_t)p->n * sizeof *xd);
    m->in[p->n] = t.hi;
    bool ok = t.hi != 0 && num_tape_eval(m->tape, m->in, at);
    m->in[p->n] = t.hi * (1 + MOVE);
    ok = ok && num_tape_eval(m->tape, m->in, moved);
    for (int i = 0; i < m->c && ok; i++)
        ok = fabs(num_jet2_root(p->constraint, i)[0].hi) <= ROUNDINGS * NUM_DD_EPSILON * fabs(moved[i] - at[i]) / MOVE;
    return ok;
}

bool precise_project(struct precise *p, num_dd t, num_dd *x, const double *scale, const unsigned char *held,
                     double *moved, double *residual)
{
    struct manifold *m = p->flow->manifold;
    *moved = *residual = 0;
    if (m->c == 0)
        return true;
    double *xd = sga_malloc((size_t)p->n * sizeof *xd), last = INFINITY, size = rounding(p, x, scale) / NUM_DD_EPSILON;
    num_dd *start = memcpy(sga_malloc((size_t)p->n * sizeof *start), x, (size_t)p->n * sizeof *x);
    bool ok = false;
    for (int k = 0; k <= STEPS; k++) {
        double worst = linearise(p, t, x, xd, scale, held, residual);
        ok = worst >= 0 && (worst <= rounding(p, x, scale) || (worst >= 0.5 * last && (worst < STALLED * size || within_time(p, t, xd))));
        if (ok || worst < 0 || k == STEPS)
            break;
        last = worst;
        if ((held && normal_is_sparse(m->step) ? normal_basic_step(m->step, m->r, m->d) : normal_step(m->step, m->r, m->d)) == 0)
            break;
        for (int j = 0; j < p->n; j++)
            if (!held || !held[j])
                x[j] = num_dd_add_d(x[j], m->d[j] * (scale ? scale : p->flow->manifold->unit)[j]);
    }
    double sum = 0;
    for (int j = 0; j < p->n; j++)
        sum += pow(num_dd_sub(x[j], start[j]).hi / (scale ? scale : p->flow->manifold->unit)[j], 2);
    *moved = p->n ? sqrt(sum / p->n) : 0;
    free(xd);
    free(start);
    return ok;
}

bool precise_jacobian(struct precise *p, num_dd t, const num_dd *x, const double *scale, const unsigned char *held, num_dd *J)
{
    int n = p->n, c = p->flow->manifold->c;
    bool ok = true;
    for (int j = 0; j < n && ok; j++) {
        num_jet2_input(p->constraint, j)[1] = num_dd_of(1);
        ok = precise_residuals(p, t, x, 1);
        num_jet2_input(p->constraint, j)[1] = num_dd_of(0);
        for (int i = 0; i < c; i++)
            J[i * n + j] = held && held[j] ? num_dd_of(0) : num_dd_mul_d(num_jet2_root(p->constraint, i)[1], scale[j]);
    }
    return ok;
}

/* Gauss elimination of the symmetric G (c x c) with pivots from the diagonal, the right side along: rows
 * that depend on others are left out, w there 0. */
static void solve_symmetric(num_dd *G, num_dd *r, num_dd *w, int c)
{
    unsigned char *used = sga_calloc((size_t)c, 1);
    int *order = sga_malloc((size_t)c * sizeof *order), rank = 0;
    double first = 0;
    for (; rank < c; rank++) {
        int best = -1;
        for (int i = 0; i < c; i++)
            if (!used[i] && (best < 0 || G[i * c + i].hi > G[best * c + best].hi))
                best = i;
        double pivot = G[best * c + best].hi;
        first = rank ? first : pivot;
        if (!(pivot > DEPENDENT * first))
            break;
        used[best] = 1;
        order[rank] = best;
        for (int i = 0; i < c; i++) {
            if (used[i])
                continue;
            num_dd f = num_dd_div(G[i * c + best], G[best * c + best]);
            for (int k = 0; k < c; k++)
                G[i * c + k] = num_dd_sub(G[i * c + k], num_dd_mul(f, G[best * c + k]));
            r[i] = num_dd_sub(r[i], num_dd_mul(f, r[best]));
        }
    }
    for (int i = 0; i < c; i++)
        w[i] = num_dd_of(0);
    for (int q = rank - 1; q >= 0; q--) {
        int i = order[q];
        num_dd sum = r[i];
        for (int k = q + 1; k < rank; k++)
            sum = num_dd_sub(sum, num_dd_mul(G[i * c + order[k]], w[order[k]]));
        w[i] = num_dd_div(sum, G[i * c + i]);
    }
    free(used);
    free(order);
}

/* g (n, in units of scale) less its part normal to the set, in double-double. */
static void along_set(const struct precise *p, const num_dd *J, const num_dd *g, double *out)
{
    int n = p->n, c = p->flow->manifold->c;
    num_dd *G = sga_malloc(((size_t)c + 2) * (size_t)c * sizeof *G), *r = G + c * c, *w = r + c;
    for (int i = 0; i < c; i++) {
        r[i] = num_dd_of(0);
        for (int j = 0; j < n; j++)
            r[i] = num_dd_add(r[i], num_dd_mul(J[i * n + j], g[j]));
        for (int k = 0; k < c; k++) {
            num_dd s = num_dd_of(0);
            for (int j = 0; j < n; j++)
                s = num_dd_add(s, num_dd_mul(J[i * n + j], J[k * n + j]));
            G[i * c + k] = s;
        }
    }
    solve_symmetric(G, r, w, c);
    for (int j = 0; j < n; j++) {
        num_dd d = g[j];
        for (int i = 0; i < c; i++)
            d = num_dd_sub(d, num_dd_mul(J[i * n + j], w[i]));
        out[j] = d.hi;
    }
    free(G);
}

/* x, near it, goes to the point of the set that is nearest to the guess in the variables that count: Newton's steps in double
 * for gradients in double-double. False: it does not settle. */
static bool nearest(struct precise *p, const num_dd *guess, const double *unit, const struct nearest *q, num_dd *x)
{
    int n = p->n, c = p->flow->manifold->c;
    num_dd *J = sga_malloc(((size_t)c * (size_t)n + (size_t)n) * sizeof *J), *g = J + c * n;
    double *xd = sga_malloc(3 * (size_t)n * sizeof *xd), *gradient = xd + n, *step = gradient + n, last = INFINITY, moved, residual;
    const unsigned char *fixed = q->t->fixed;
    bool ok = false;
    for (int k = 0; k < NEAREST_STEPS && !ok; k++) {
        double length = 0, size = 1e-3;
        for (int j = 0; j < n; j++) {
            g[j] = fixed[j] || !(q->weight[j] > 0) ? num_dd_of(0) : num_dd_div(num_dd_sub(x[j], guess[j]), num_dd_of(unit[j]));
            size = fmax(size, fabs(x[j].hi) / unit[j]);
            xd[j] = x[j].hi;
        }
        if (!precise_jacobian(p, p->start, x, unit, fixed, J))
            break;
        along_set(p, J, g, gradient);
        nearest_refine(q, xd, gradient, step);
        for (int j = 0; j < n; j++) {
            x[j] = num_dd_add_d(x[j], step[j] * unit[j]);
            length = fmax(length, fabs(step[j]));
        }
        if (!(length < last || length < SMALL_STEP) || !precise_project(p, p->start, x, unit, fixed, &moved, &residual))
            break;
        last = length;
        ok = length < 100 * NUM_DD_EPSILON * size;
    }
    free(J);
    free(xd);
    return ok;
}

/* From x, a start in double: in this stage (tiers.h) what stays is the exact guess, the first tier the nearest point. */
static bool settle_stage(struct precise *p, const num_dd *guess, const double *x, const double *unit, const unsigned char *kind,
                         enum tiers_stage stage)
{
    const struct traj_request *rq = p->rq;
    int n = p->n, *by_name = sga_malloc((size_t)(n + 1) * sizeof *by_name);
    signed char *tier = sga_malloc((size_t)n + 1);
    double moved, residual, *weight = sga_malloc((size_t)(n + 1) * sizeof *weight);
    struct tangent t;
    tangent_init(&t, p->flow->manifold, unit);
    tiers_of(rq, kind, n, stage, tier);
    for (int j = 0; j < n; j++) {
        t.fixed[j] = tier[j] < 0;
        weight[j] = tier[j] == 0;
        p->x[j] = tier[j] < 0 ? guess[j] : num_dd_of(x[j]);
    }
    tangent_fix(&t);
    sys_by_name(p->sys, by_name);
    struct nearest q = { &t, rq->start, rq->initial, weight, by_name };
    bool ok = precise_project(p, p->start, p->x, unit, t.fixed, &moved, &residual);
    if (ok && stage != TIERS_KEEP_ALL) {
        ok = nearest(p, guess, unit, &q, p->x);
        for (int j = 0; j < n && ok; j++)       /* another point than the double one: that one refined is none */
            ok = fabs(p->x[j].hi - x[j]) <= 1e-6 * unit[j];
    }
    tangent_clear(&t);
    free(tier);
    free(weight);
    free(by_name);
    return ok;
}

/* The start: what the double start left as it was given stays exactly; the rest of what was given as near as that lets it. */
static bool settle_start(struct precise *p, num_dd *guess, const double *x)
{
    const struct traj_request *rq = p->rq;
    int n = p->n;
    bool ok = false;
    double *unit = sga_malloc((size_t)(n + 1) * sizeof *unit);
    unsigned char *kind = sga_malloc((size_t)n + 1);
    sys_kinds(p->sys, kind);
    for (int j = 0; j < n; j++)
        unit[j] = sizes_move(p->flow->sizes, j, rq->initial[j]);
    for (int k = (int)tiers_stage_of(rq, kind, n, x); k < TIERS_STAGES && !ok; k++)
        if (k == TIERS_KEEP_ALL || p->flow->manifold->c <= DENSE_MOST)
            ok = settle_stage(p, guess, x, unit, kind, (enum tiers_stage)k);
    free(unit);
    free(kind);
    return ok;
}

/* Whether a given value is more than its double: where a start was placed at numbers, none is. */
static bool exact_given(const struct traj_request *rq, int j)
{
    return rq->given[j] && rq->exact_initial && rq->exact_initial[j];
}

/* The exact constants: start, times, given values. */
static bool exact_values(struct precise *p, num_dd *guess, struct sga_error *err)
{
    const struct traj_request *rq = p->rq;
    int n = p->n, count = rq->samples;
    for (int j = 0; j < n; j++)
        guess[j] = num_dd_of(rq->initial[j]);
    p->start = num_dd_of(rq->start);
    for (int k = 0; k < count; k++)
        p->time[k] = num_dd_of(rq->times[k]);
    if (!rq->exact_time)
        return true;
    expr_id *root = sga_malloc((size_t)(n + count + 1) * sizeof *root);
    expr_id zero = expr_int(p->sys->store, 0);
    root[0] = rq->exact_start;
    memcpy(root + 1, rq->exact_time, (size_t)count * sizeof *root);
    for (int j = 0; j < n; j++)
        root[1 + count + j] = exact_given(rq, j) ? rq->exact_initial[j] : zero;
    struct num_tape *t = num_tape_new(p->sys->store, root, 1 + count + n, NULL, 0, err);
    free(root);
    if (!t)
        return false;
    struct num_jet2 *j2 = num_jet2_new(t, 0);
    num_jet2_next(j2, 0);
    p->start = num_jet2_root(j2, 0)[0];
    for (int k = 0; k < count; k++)
        p->time[k] = num_jet2_root(j2, 1 + k)[0];
    for (int j = 0; j < n; j++)
        if (exact_given(rq, j))
            guess[j] = num_jet2_root(j2, 1 + count + j)[0];
    num_jet2_free(j2);
    num_tape_free(t);
    return true;
}

bool precise_start(struct precise *p, const double *x, struct sga_error *err)
{
    num_dd *guess = sga_malloc((size_t)p->n * sizeof *guess);
    bool ok = exact_values(p, guess, err);
    if (ok && p->flow->manifold->c == 0) {
        for (int j = 0; j < p->n; j++)
            p->x[j] = guess[j];
    } else if (ok && !settle_start(p, guess, x)) {
        ok = sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/initial",
                         "the point of the final constraint set nearest to the initial values is known to a double's digits only; "
                         "give values that satisfy the constraints, or fewer of them, for double-double arithmetic");
    }
    free(guess);
    return ok;
}
