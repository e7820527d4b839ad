/* Damped steps within bounds: see least_squares.h. */
#include "least_squares.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"

/* Converged below this offset; it may be so much where no step makes the sum less. A step that is so small beside the unknowns is none. The first damping,
 * beside the largest singular value's square. */
enum { PATIENCE = 5 };      /* steps that may bring nothing near the end */
static const double CONVERGED = 1e-9, NEARLY = 1e-5, NO_STEP = 1e-14, DAMPING = 1e-3;
/* Directions whose singular values are so many times the uncertainty of columns, and at the least this, are moved along. */
static const double TIMES = 30, LEAST = 1e-10;

struct walk {
    const struct fit_problem *q;
    struct fit_result *r;
    double *scale;             /* p: the columns' lengths */
    double *A, *s, *V;         /* the scaled Jacobian without what is at bounds, decomposed */
    double *along;             /* p: the residual along its left vectors */
    double *x, *value, *J;     /* a trial */
    double *step;
    unsigned char *held;       /* p: not moved */
};

static double squares(const double *r, int m)
{
    double sum = 0;
    for (int i = 0; i < m; i++)
        sum += r[i] * r[i];
    return sum;
}

static bool all_finite(const double *v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!isfinite(v[i]))
            return false;
    return true;
}

static bool evaluate(struct walk *w, const double *x, double *r, double *J)
{
    w->r->evaluations++;
    return w->q->value(w->q->ctx, x, r, J) && all_finite(r, (size_t)w->q->m) && all_finite(J, (size_t)w->q->m * (size_t)w->q->p);
}

/* Unknowns at a bound that the sum presses against it. */
static void find_bounds(struct walk *w)
{
    const struct fit_problem *q = w->q;
    for (int j = 0; j < q->p; j++) {
        double slope = 0;
        for (int i = 0; i < q->m; i++)
            slope += w->r->J[(size_t)i * (size_t)q->p + (size_t)j] * w->r->r[i];
        w->r->bound[j] = (w->r->x[j] <= q->low[j] && slope > 0) || (w->r->x[j] >= q->high[j] && slope < 0);
    }
}

/* The decomposition at the present point; how many directions are told. */
static int decompose(struct walk *w)
{
    const struct fit_problem *q = w->q;
    size_t p = (size_t)q->p;
    find_bounds(w);
    for (size_t j = 0; j < p; j++) {
        double length = 0;
        for (int i = 0; i < q->m; i++)
            length = hypot(length, w->r->J[(size_t)i * p + j]);
        w->scale[j] = length;
        for (int i = 0; i < q->m; i++)
            w->A[(size_t)i * p + j] = w->r->bound[j] || w->held[j] || !(w->scale[j] > 0) ? 0 : w->r->J[(size_t)i * p + j] / w->scale[j];
    }
    fit_singular_values(w->A, q->m, q->p, w->s, w->V);
    int rank = 0;
    while (rank < q->p && w->s[rank] > fmax(TIMES * q->unsure, LEAST) * w->s[0] && w->s[rank] > 0)
        rank++;
    double part = 0;
    assert(rank == q->p || !(w->s[rank] > w->s[0]));
    for (int k = 0; k < q->p; k++) {
        w->along[k] = 0;
        for (int i = 0; i < q->m; i++)
            w->along[k] += w->A[(size_t)i * p + (size_t)k] * w->r->r[i];
        part += k < rank ? w->along[k] * w->along[k] : 0;
    }
    w->r->offset = part > 0 ? sqrt(part / w->r->sum) : 0;
    return rank;
}

static double moved(const double *step, const double *x, int p)
{
    double most = 0;
    for (int j = 0; j < p; j++)
        most = fmax(most, fabs(step[j]) / (fabs(x[j]) + fabs(step[j]) + 1e-300));
    return most;
}

/* The trial point with this damping, and how much less the sum is there by the derivatives. */
static double try_step(struct walk *w, int rank, double damping)
{
    const struct fit_problem *q = w->q;
    size_t p = (size_t)q->p;
    double less = w->r->sum;
    for (size_t j = 0; j < p; j++) {
        double d = 0;
        for (int k = 0; k < rank; k++)
            d -= w->V[(size_t)k * p + j] * w->s[k] / (w->s[k] * w->s[k] + damping) * w->along[k];
        d = w->scale[j] > 0 && !w->r->bound[j] && !w->held[j] ? d / w->scale[j] : 0;
        w->x[j] = fmin(fmax(w->r->x[j] + d, q->low[j]), q->high[j]);
        w->step[j] = w->x[j] - w->r->x[j];
    }
    for (int i = 0; i < q->m; i++) {
        double r = w->r->r[i];
        for (size_t j = 0; j < p; j++)
            r += w->r->J[(size_t)i * p + j] * w->step[j];
        less -= r * r;
    }
    return less;
}

static void take(struct walk *w, double sum)
{
    size_t m = (size_t)w->q->m, p = (size_t)w->q->p;
    memcpy(w->r->x, w->x, p * sizeof *w->x);
    memcpy(w->r->r, w->value, m * sizeof *w->value);
    memcpy(w->r->J, w->J, m * p * sizeof *w->J);
    for (size_t j = 0; j < p; j++)
        w->r->size[j] = fmax(w->r->size[j], fabs(w->x[j]));
    assert(!(sum > w->r->sum * (1 + 1e-12)));
    w->r->sum = sum;
    w->r->steps++;
}

/* Nothing is left along what the unknowns can change. */
static bool converged(const struct walk *w)
{
    return w->r->offset <= CONVERGED || w->r->offset * sqrt(w->r->sum) <= w->q->noise;
}

static enum fit_status walk(struct walk *w)
{
    double damping = DAMPING, growth = 2, least = INFINITY;
    int rank = decompose(w), since = 0;         /* steps since the offset was least */
    damping *= w->s[0] * w->s[0];
    for (;;) {
        if (w->q->goes_on && !w->q->goes_on(w->q->ctx))
            return FIT_STOPPED;
        if (converged(w))
            return FIT_CONVERGED;
        if (w->r->steps >= w->q->most)
            return FIT_TOO_MANY;
        double less = try_step(w, rank, damping);
        if (moved(w->step, w->r->x, w->q->p) < NO_STEP)
            return w->r->offset <= NEARLY ? FIT_CONVERGED : FIT_STALLED;
        bool ok = less > 0 && evaluate(w, w->x, w->value, w->J);
        double sum = ok ? squares(w->value, w->q->m) : INFINITY, gain = (w->r->sum - sum) / less;
        if (ok && (gain > 1e-4 || (sum <= w->r->sum * (1 + 1e-12) && less < 1e-10 * w->r->sum))) {
            take(w, sum);
            rank = decompose(w);
            since = w->r->offset < 0.9 * least ? 0 : since + 1;
            least = fmin(least, w->r->offset);
            if (since >= PATIENCE && w->r->offset <= NEARLY)         /* as near as the derivatives are good */
                return FIT_CONVERGED;
            damping *= fmax(1.0 / 3, 1 - pow(2 * fmin(gain, 1) - 1, 3));
            growth = 2;
        } else {
            damping *= growth;
            growth *= 2;
        }
    }
}

/* Which unknowns change r by no more than the noise as they change by their size, at the guess. False: none, or all. */
static bool find_unseen(const struct walk *w, unsigned char *unseen)
{
    size_t p = (size_t)w->q->p, count = 0;
    for (size_t j = 0; j < p; j++) {
        double length = 0, size = w->r->x[j] != 0 ? fabs(w->r->x[j]) : 1;
        for (int i = 0; i < w->q->m; i++)
            length = hypot(length, w->r->J[(size_t)i * p + j]);
        unseen[j] = length * size <= w->q->noise;
        count += unseen[j];
    }
    return count > 0 && count < p;
}

static bool at_guess(struct walk *w, const double *x)
{
    struct fit_result *r = w->r;
    for (int j = 0; j < w->q->p; j++) {
        r->x[j] = fmin(fmax(x[j], w->q->low[j]), w->q->high[j]);
        r->size[j] = fabs(r->x[j]);
    }
    bool ok = evaluate(w, r->x, r->r, r->J);
    r->sum = ok ? squares(r->r, w->q->m) : 0;
    r->steps = 0;
    return ok;
}

void fit_least_squares(const struct fit_problem *q, const double *x, struct fit_result *result)
{
    size_t m = (size_t)q->m, p = (size_t)q->p;
    assert(q->m >= 0 && q->p > 0);
    *result = (struct fit_result){ .x = sga_calloc(p + 1, sizeof *x), .r = sga_calloc(m + 1, sizeof *x), .J = sga_calloc(m * p + 1, sizeof *x), .bound = sga_calloc(p + 1, 1),
                                   .size = sga_calloc(p + 1, sizeof *x) };
    SGA_ARENA(mem);
    struct walk w = { .q = q, .r = result, .scale = sga_zeros(&mem, p + 1, sizeof *x), .A = sga_zeros(&mem, m * p + 1, sizeof *x), .s = sga_zeros(&mem, p + 1, sizeof *x),
                      .V = sga_zeros(&mem, p * p + 1, sizeof *x), .along = sga_zeros(&mem, p + 1, sizeof *x), .x = sga_zeros(&mem, p + 1, sizeof *x),
                      .value = sga_zeros(&mem, m + 1, sizeof *x), .J = sga_zeros(&mem, m * p + 1, sizeof *x), .step = sga_zeros(&mem, p + 1, sizeof *x),
                      .held = sga_zeros(&mem, p + 1, 1) };
    unsigned char *unseen = sga_zeros(&mem, p + 1, 1);
    result->status = FIT_NO_VALUE;
    if (!at_guess(&w, x))
        return;
    bool some = find_unseen(&w, unseen);
    result->status = walk(&w);
    if (some && (result->status == FIT_STALLED || result->status == FIT_TOO_MANY)) {
        memcpy(w.held, unseen, p);
        result->status = at_guess(&w, x) ? walk(&w) : FIT_NO_VALUE;
    }
    for (size_t j = 0; j < p; j++)
        result->size[j] = result->size[j] > 0 ? result->size[j] : 1;
}

void fit_result_clear(struct fit_result *r)
{
    free(r->x);
    free(r->r);
    free(r->J);
    free(r->bound);
    free(r->size);
    *r = (struct fit_result){ 0 };
}
