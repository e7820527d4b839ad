/* Points of the final set in double-double: projection, and the consistent start. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "precise.h"

#define STEPS 12
/* A residual that no longer falls may be this large against what it is of. */
#define STALLED 1e-26
#define NEAREST_STEPS 400
/* More constraints than this are not solved for in dense double-double. */
#define DENSE_MOST 200
/* Pivots of J J^T this much below the first one are dependent rows. */
#define DEPENDENT 1e-22

/* Constraint values at x; false where they are not finite. Coefficient 1 of the inputs is as it was. */
static bool residuals(struct precise *p, num_dd t, const num_dd *x, int order)
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
    struct manifold *m = &p->flow->manifold;
    for (int j = 0; j < p->n; j++)
        xd[j] = x[j].hi;
    if (manifold_residual(m, t.hi, xd, scale, held) < 0 || !residuals(p, t, x, 0))
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
        size = fmax(size, fabs(x[j].hi) / (scale ? scale : p->flow->manifold.unit)[j]);
    return 2 * NUM_DD_EPSILON * size;
}

bool precise_project(struct precise *p, num_dd t, num_dd *x, const double *scale, const unsigned char *held,
                     double *moved, double *residual)
{
    struct manifold *m = &p->flow->manifold;
    *moved = *residual = 0;
    if (m->c == 0)
        return true;
    double *xd = sga_malloc((size_t)p->n * sizeof *xd), last = INFINITY, size = rounding(p, x, scale) / NUM_DD_EPSILON;
    num_dd *start = memcpy(sga_malloc((size_t)p->n * sizeof *start), x, (size_t)p->n * sizeof *x);
    bool ok = false;
    for (int k = 0; k <= STEPS; k++) {
        double worst = linearise(p, t, x, xd, scale, held, residual);
        ok = worst >= 0 && (worst <= rounding(p, x, scale) || (worst < STALLED * size && worst >= 0.5 * last));
        if (ok || worst < 0 || k == STEPS)
            break;
        last = worst;
        if ((held && m->step.kkt ? normal_basic_step(&m->step, m->r, m->d) : normal_step(&m->step, m->r, m->d)) == 0)
            break;
        for (int j = 0; j < p->n; j++)
            if (!held || !held[j])
                x[j] = num_dd_add_d(x[j], m->d[j] * (scale ? scale : p->flow->manifold.unit)[j]);
    }
    double sum = 0;
    for (int j = 0; j < p->n; j++)
        sum += pow(num_dd_sub(x[j], start[j]).hi / (scale ? scale : p->flow->manifold.unit)[j], 2);
    *moved = sqrt(sum / p->n);
    free(xd);
    free(start);
    return ok;
}

/* J (c x n) in units of scale, held columns 0, by a directional derivative for each column. */
static bool jacobian(struct precise *p, num_dd t, const num_dd *x, const double *scale, const unsigned char *held, num_dd *J)
{
    int n = p->n, c = p->flow->manifold.c;
    bool ok = true;
    for (int j = 0; j < n && ok; j++) {
        num_jet2_input(p->constraint, j)[1] = num_dd_of(1);
        ok = residuals(p, t, x, 1);
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

/* One step of manifold_nearest in double-double: d = shift - J^T (J J^T)^-1 (r + J shift), in units of scale. */
static bool nearest_step(struct precise *p, const num_dd *J, const num_dd *shift, num_dd *d)
{
    int n = p->n, c = p->flow->manifold.c;
    num_dd *G = sga_malloc(((size_t)c + 2) * (size_t)c * sizeof *G), *r = G + c * c, *w = r + c;
    bool ok = true;
    for (int i = 0; i < c; i++) {
        r[i] = num_jet2_root(p->constraint, i)[0];
        for (int j = 0; j < n; j++)
            r[i] = num_dd_add(r[i], num_dd_mul(J[i * n + j], shift[j]));
        for (int k = 0; k < c; k++) {
            num_dd s = num_dd_of(0);
            for (int j = 0; j < n; j++)
                s = num_dd_add(s, num_dd_mul(J[i * n + j], J[k * n + j]));
            G[i * c + k] = s;
        }
    }
    solve_symmetric(G, r, w, c);
    for (int j = 0; j < n && ok; j++) {
        d[j] = shift[j];
        for (int i = 0; i < c; i++)
            d[j] = num_dd_sub(d[j], num_dd_mul(J[i * n + j], w[i]));
        ok = num_dd_finite(d[j]);
    }
    free(G);
    return ok;
}

/* x goes to the point of the set that is nearest to the guess. False: it does not settle. */
static bool nearest(struct precise *p, const num_dd *guess, const double *scale, const unsigned char *held, num_dd *x)
{
    int n = p->n, c = p->flow->manifold.c;
    num_dd *J = sga_malloc(((size_t)c * (size_t)n + 2 * (size_t)n) * sizeof *J), *shift = J + c * n, *d = shift + n;
    bool ok = false;
    for (int k = 0; k < NEAREST_STEPS && !ok; k++) {
        double length = 0, size = 1e-3;
        for (int j = 0; j < n; j++) {
            shift[j] = held && held[j] ? num_dd_of(0) : num_dd_div(num_dd_sub(guess[j], x[j]), num_dd_of(scale[j]));
            size = fmax(size, fabs(x[j].hi) / scale[j]);
        }
        if (!jacobian(p, p->start, x, scale, held, J) || !residuals(p, p->start, x, 0) || !nearest_step(p, J, shift, d))
            break;
        for (int j = 0; j < n; j++) {
            if (!held || !held[j])
                x[j] = num_dd_add(x[j], num_dd_mul_d(d[j], scale[j]));
            length = fmax(length, fabs(d[j].hi));
        }
        ok = length < 100 * NUM_DD_EPSILON * size;
    }
    free(J);
    return ok;
}

/* The point nearest for the given values alone, as consistent.c has it: the guess of the others follows them,
 * which moves the point some 1e-6 as much in each round. */
static bool nearest_given(struct precise *p, num_dd *guess, const double *scale, num_dd *x)
{
    enum { ROUNDS = 12 };
    int n = p->n;
    bool ok = true, settled = false;
    num_dd *before = sga_malloc((size_t)n * sizeof *before);
    for (int k = 0; k < ROUNDS && ok && !settled; k++) {
        for (int j = 0; j < n; j++) {
            before[j] = x[j];
            if (!p->rq->given[j])
                guess[j] = x[j];
        }
        ok = nearest(p, guess, scale, p->rq->held, x);
        settled = true;
        for (int j = 0; j < n; j++)
            settled &= fabs(num_dd_sub(x[j], before[j]).hi) <= 200 * NUM_DD_EPSILON * fmax(scale[j], fabs(x[j].hi));
    }
    free(before);
    return ok && settled;
}

/* As consistent.c weighs what a value moves by. */
static double unit_of(const struct precise *p, const struct traj_request *rq, int j)
{
    return sizes_move(&p->flow->sizes, j, rq->initial[j]) * (rq->given[j] ? 1 : 1e3);
}

/* The start: where the double start left what was given as it was, that stays exactly; otherwise
 * the nearest point, and where that is another point than the double one, the double one refined. */
static bool settle_start(struct precise *p, num_dd *guess, const double *x)
{
    const struct traj_request *rq = p->rq;
    int n = p->n;
    bool kept = true, ok = false;
    double moved, residual, *scale = sga_malloc((size_t)n * sizeof *scale);
    unsigned char *fixed = sga_malloc((size_t)n);
    for (int j = 0; j < n; j++) {
        fixed[j] = rq->given[j] || (rq->held && rq->held[j]);
        kept &= !fixed[j] || x[j] == rq->initial[j];
        scale[j] = unit_of(p, rq, j);
    }
    for (int j = 0; j < n; j++)
        p->x[j] = fixed[j] && kept ? guess[j] : num_dd_of(x[j]);
    if (kept)
        ok = precise_project(p, p->start, p->x, NULL, fixed, &moved, &residual);
    if (!ok && p->flow->manifold.c <= DENSE_MOST) {
        for (int j = 0; j < n; j++)
            p->x[j] = rq->held && rq->held[j] ? guess[j] : num_dd_of(x[j]);
        ok = nearest_given(p, guess, scale, p->x);
        for (int j = 0; j < n && ok; j++)
            ok = fabs(p->x[j].hi - x[j]) <= 1e-6 * scale[j];
        ok = ok && precise_project(p, p->start, p->x, NULL, rq->held, &moved, &residual);
    }
    free(scale);
    free(fixed);
    return ok;
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
        root[1 + count + j] = rq->given[j] && rq->exact_initial[j] ? rq->exact_initial[j] : zero;
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
        if (rq->given[j] && rq->exact_initial[j])
            guess[j] = num_jet2_root(j2, 1 + count + j)[0];
    num_jet2_free(j2);
    num_tape_free(t);
    return true;
}

bool precise_start(struct precise *p, const double *x, struct sga_error *err)
{
    num_dd *guess = sga_malloc((size_t)p->n * sizeof *guess);
    bool ok = exact_values(p, guess, err);
    if (ok && p->flow->manifold.c == 0) {
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
