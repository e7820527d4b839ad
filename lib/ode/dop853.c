/* Dormand-Prince 8(5,3): the explicit method for middle and high accuracy.
 *
 * Twelve stages give the step of order 8; two embedded formulas of order 5 and 3 are
 * combined to one error estimate that falls as h^8; three more stages give a polynomial
 * of order 7 over the step, asked for only where samples fall inside. Hairer, Norsett,
 * Wanner, Solving Ordinary Differential Equations I, II.5, II.6 and (stiffness) the
 * companion volume IV.2. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dop853_tables.h"
#include "mem.h"
#include "method.h"

/* Where the stability region ends on the negative real axis. */
#define STABILITY_LIMIT 6.1
/* See trusted_ratio. */
#define BELIEVED_FALL 0.3
#define MEMORY 0.5

struct dop853 {
    int n;
    double *k;        /* DOP853_ALL x n: the field at the stages */
    double *y;        /* n: the state at the present stage */
    double *y_last;   /* n: the state at the last of the twelve stages */
    double *poly;     /* 7 x n: the polynomial's coefficients */
    double ratio;     /* of the estimates of order 5 and 3, over h^2, lately */
};

static void *dop853_alloc(const struct ode_problem *p)
{
    struct dop853 *d = sga_malloc(sizeof *d);
    size_t m = (size_t)p->n;
    d->n = p->n;
    d->ratio = 0;
    d->k = sga_calloc((DOP853_ALL + 1 + 1 + 7) * m + 1, sizeof *d->k);
    d->y = d->k + DOP853_ALL * m;
    d->y_last = d->y + m;
    d->poly = d->y_last + m;
    return d;
}

static void dop853_free(void *state)
{
    struct dop853 *d = state;
    free(d->k);
    free(d);
}

/* out = sum_s a_s k_s; four variables at a time, whose sums stay in registers. */
static void combine(const struct dop853_row *r, const double *k, int n, double *out)
{
    int j = 0;
    for (; j + 4 <= n; j += 4) {
        double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
        for (int m = 0; m < r->count; m++) {
            const double *at = k + (size_t)r->stage[m] * (size_t)n + (size_t)j, a = r->a[m];
            s0 += a * at[0];
            s1 += a * at[1];
            s2 += a * at[2];
            s3 += a * at[3];
        }
        out[j] = s0;
        out[j + 1] = s1;
        out[j + 2] = s2;
        out[j + 3] = s3;
    }
    for (; j < n; j++) {
        double sum = 0;
        for (int m = 0; m < r->count; m++)
            sum += r->a[m] * k[(size_t)r->stage[m] * (size_t)n + (size_t)j];
        out[j] = sum;
    }
}

static bool run_stage(struct dop853 *d, struct ode_field *field, const struct ode_step *step,
                      int s, double *y)
{
    combine(&dop853_a[s], d->k, d->n, y);
    for (int j = 0; j < d->n; j++)
        y[j] = step->x[j] + step->h * y[j];
    double t = step->t + (step->t_low + dop853_c[s] * step->h);
    return ode_eval(field, t, y, d->k + (size_t)s * (size_t)d->n);
}

/* e5 can pass through 0 by accident, most of all with few variables, and a step of any
 * error is then accepted. The ratio of the two estimates falls as h^2, so a ratio far
 * below that of the steps before, scaled, is such an accident, and is not believed. */
static double trusted_ratio(struct dop853 *d, double ratio, double h)
{
    double least = fmin(1, BELIEVED_FALL * d->ratio * h * h);
    d->ratio = fmax(ratio / (h * h), MEMORY * d->ratio);
    return fmax(ratio, least);
}

/* The increment, and the error estimate of both embedded formulas together:
 * |h| e5^2 / sqrt(e5^2 + 0.01 e3^2), root mean square over the variables. */
static void finish_step(struct dop853 *d, struct ode_step *step)
{
    double e5 = 0, e3 = 0, *low = d->y, *middle = d->poly;
    combine(&dop853_a[DOP853_END], d->k, d->n, step->dx);
    combine(&dop853_error5, d->k, d->n, middle);
    combine(&dop853_weights3, d->k, d->n, low);
    for (int j = 0; j < d->n; j++) {
        double a5 = middle[j], a3 = step->dx[j] - low[j];
        step->dx[j] *= step->h;
        double allowed = ode_allowed(step->rtol, step->atol, step->unit[j], step->x[j],
                                     step->x[j] + step->dx[j]);
        e5 += (a5 / allowed) * (a5 / allowed);
        e3 += (a3 / allowed) * (a3 / allowed);
    }
    double both = e5 + 0.01 * e3;
    double ratio = both > 0 ? sqrt(e5 / both) : 0;
    step->error = both > 0 ? fabs(step->h) * sqrt(both / d->n) * pow(trusted_ratio(d, ratio, step->h), 2) : 0;
}

static enum ode_outcome dop853_attempt(void *state, struct ode_field *field, struct ode_step *step)
{
    struct dop853 *d = state;
    memcpy(d->k, step->f, (size_t)d->n * sizeof *d->k);
    for (int s = 1; s < DOP853_STAGES; s++)
        if (!run_stage(d, field, step, s, s == DOP853_STAGES - 1 ? d->y_last : d->y))
            return ODE_FIELD_REFUSED;
    finish_step(d, step);
    step->dense_error = step->doubt = step->error;
    step->error_order = 8;
    step->cost = DOP853_STAGES;
    return ODE_STEPPED;
}

static void dop853_forget(void *state)
{
    struct dop853 *d = state;
    d->ratio = 0;
}

/* Both the last stage and the end belong to the time t + h: the field's difference over
 * the states' is an eigenvalue estimate. */
static double dop853_stiffness(const void *state, const struct ode_step *step)
{
    const struct dop853 *d = state;
    const double *k = d->k + (size_t)(DOP853_STAGES - 1) * (size_t)d->n;
    double up = 0, down = 0;
    for (int j = 0; j < d->n; j++) {
        double df = (step->f1[j] - k[j]) / step->unit[j];
        double dx = (step->x1[j] - d->y_last[j]) / step->unit[j];
        up += df * df;
        down += dx * dx;
    }
    return down > 0 ? fabs(step->h) * sqrt(up / down) / STABILITY_LIMIT : 0;
}

static bool dop853_dense_begin(void *state, struct ode_field *field, struct ode_step *step)
{
    struct dop853 *d = state;
    size_t n = (size_t)d->n;
    double h = step->h;
    memcpy(d->k + DOP853_END * n, step->f1, n * sizeof *d->k);
    for (int s = DOP853_END + 1; s < DOP853_ALL; s++)
        if (!run_stage(d, field, step, s, d->y))
            return false;
    for (int j = 0; j < d->n; j++) {
        double rise = step->x1[j] - step->x[j];
        d->poly[j] = rise;
        d->poly[n + (size_t)j] = h * step->f[j] - rise;
        d->poly[2 * n + (size_t)j] = 2 * rise - h * (step->f[j] + step->f1[j]);
    }
    for (size_t r = 3; r < 7; r++) {
        combine(&dop853_dense[r - 3], d->k, d->n, d->poly + r * n);
        for (size_t j = 0; j < n; j++)
            d->poly[r * n + j] *= h;
    }
    return true;
}

/* Horner in alternating theta and 1 - theta. */
static void dop853_dense_at(const void *state, const struct ode_step *step, double theta,
                            double *x)
{
    const struct dop853 *d = state;
    for (int j = 0; j < d->n; j++) {
        double s = 0;
        for (int r = 6; r >= 0; r--)
            s = (s + d->poly[(size_t)r * (size_t)d->n + (size_t)j]) *
                (r % 2 ? 1 - theta : theta);
        x[j] = step->x[j] + s;
    }
}

const struct ode_method ode_dop853 = {
    .name = "dop853",
    .what = "explicit Runge-Kutta of order 8 (Dormand-Prince 8(5,3)), dense output of order 7",
    .order = 8,
    .error_order = 8,
    .alloc = dop853_alloc,
    .free = dop853_free,
    .attempt = dop853_attempt,
    .forget = dop853_forget,
    .dense_begin = dop853_dense_begin,
    .stiffness = dop853_stiffness,
    .dense_at = dop853_dense_at,
};
