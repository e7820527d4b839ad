/* Tsitouras 5(4): the explicit method for low accuracy, and for many samples.
 *
 * Six stages give the step of order 5, the field at its end is the seventh and the first of
 * the next one; the embedded formula of order 4 gives the error estimate; the polynomial of
 * order 4 over the step needs no more evaluations. The tables' header names the source;
 * stiffness as in Hairer, Wanner, Solving Ordinary Differential Equations II, IV.2. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "rk_step.h"
#include "tsit5_tables.h"

/* Where the stability region ends on the negative real axis. */
#define STABILITY_LIMIT 3.5
enum { VECTORS = TSIT5_STAGES + 8 };

struct tsit5 {
    int n;
    size_t even;      /* n, made even */
    size_t stride;    /* from one vector to the next */
    double *k;        /* TSIT5_STAGES vectors: the field at the stages */
    double *x;        /* the start of the step */
    double *y, *y_last, *end;   /* states: at the present stage; at the stage before the end; at the end */
    struct sga_stages plan;
    double *poly;     /* 4 vectors: the polynomial's coefficients */
};

static void *tsit5_alloc(const struct ode_problem *p)
{
    struct tsit5 *d = sga_malloc(sizeof *d);
    d->n = p->n;
    d->even = rk_even(p->n);
    d->stride = rk_stride(d->even);
    d->k = sga_calloc(VECTORS * d->stride + 1, sizeof *d->k);
    d->x = d->k + TSIT5_STAGES * d->stride;
    d->y = d->x + d->stride;
    d->y_last = d->y + d->stride;
    d->end = d->y_last + d->stride;
    d->poly = d->end + d->stride;
    d->plan = (struct sga_stages){.count = TSIT5_STAGES, .c = tsit5_c, .row = tsit5_a, .stride = d->stride,
                                  .x = (size_t)(d->x - d->k), .y = (size_t)(d->y_last - d->k), .keep = TSIT5_END - 1};
    return d;
}

static void tsit5_free(void *state)
{
    struct tsit5 *d = state;
    free(d->k);
    free(d);
}

RK_INLINE bool run_stage(struct tsit5 *d, struct ode_field *field, const struct ode_step *step, int s, size_t stride)
{
    double *y = s == TSIT5_END ? d->end : s == TSIT5_END - 1 ? d->y_last : d->y;
    for (size_t j = 0; j < d->even; j += 2)
        *(rk_two *)(y + j) = rk_stage(&tsit5_a[s], step->h, d->x, d->k, stride, j);
    return ode_eval_stage(field, rk_time(step, tsit5_c[s]), y, d->k + (size_t)s * stride);
}

/* The increment, and its error estimate, root mean square over the variables. */
RK_INLINE void finish_step(struct tsit5 *d, struct ode_step *step, size_t stride)
{
    rk_two sum = {0, 0};
    for (int j = 0; j < d->n; j += 2) {
        rk_two dx = step->h * rk_pair(&tsit5_a[TSIT5_END], d->k, stride, (size_t)j), x = *(const rk_two *)(d->x + j);
        rk_two scale = 1 / rk_allowed(step->rtol, step->atol, rk_of(step->unit, d->n, j, 1), x, *(const rk_two *)(d->end + j));
        rk_two e = rk_pair(&tsit5_error, d->k, stride, (size_t)j) * scale;
        sum += e * e;
        step->dx[j] = dx[0];
        if (j + 1 < d->n)
            step->dx[j + 1] = dx[1];
    }
    double square = d->n ? (sum[0] + sum[1]) / d->n : 0, h = step->h;      /* without variables everything is said by time alone */
    step->error = fabs(h) * sqrt(square);
    step->log_error = 0.5 * ode_rough_log(h * h * square);
}

RK_INLINE enum ode_outcome attempt_with(struct tsit5 *d, struct ode_field *field, struct ode_step *step, size_t stride)
{
    for (int j = 0; j < d->n; j += 2) {
        *(rk_two *)(d->k + j) = rk_of(step->f, d->n, j, 0);
        *(rk_two *)(d->x + j) = rk_of(step->x, d->n, j, 0);
    }
    if (rk_as_one(&d->plan, field, step, d->k) && rk_holds(field, d->k, TSIT5_STAGES, d->even, stride)) {
        finish_step(d, step, stride);
        return ODE_STEPPED;
    }
#pragma GCC unroll 7
    for (int s = 1; s < TSIT5_STAGES; s++)
        if (!run_stage(d, field, step, s, stride))
            return ODE_FIELD_REFUSED;
    finish_step(d, step, stride);
    return ODE_STEPPED;
}

static enum ode_outcome tsit5_attempt(void *state, struct ode_field *field, struct ode_step *step)
{
    struct tsit5 *d = state;
    enum ode_outcome o = d->stride == RK_NEAR ? attempt_with(d, field, step, RK_NEAR) : attempt_with(d, field, step, d->stride);
    step->dense_error = step->doubt = step->error;
    step->error_order = 5;
    step->cost = TSIT5_END;
    step->f_end = d->k + TSIT5_END * d->stride;
    return o;
}

/* The last stage but one belongs to the time t + h too: the field's difference over the
 * states' is an eigenvalue estimate. */
static bool tsit5_stiff(const void *state, const struct ode_step *step)
{
    const struct tsit5 *d = state;
    const double *before = d->k + (TSIT5_END - 1) * d->stride, *last = before + d->stride;
    return rk_stiff(step->n, step->unit, step->h, last, before, d->end, d->y_last, STABILITY_LIMIT);
}

static bool tsit5_dense_begin(void *state, struct ode_field *field, struct ode_step *step)
{
    (void)field;
    struct tsit5 *d = state;
    size_t m = d->stride;
    for (size_t r = 0; r < 4; r++)
        for (size_t j = 0; j < d->even; j++) {
            double sum = 0;
            for (size_t s = 0; s < TSIT5_STAGES; s++)
                sum += tsit5_dense[s][r] * d->k[s * m + j];
            d->poly[r * m + j] = step->h * sum;
        }
    return true;
}

static void tsit5_dense_at(const void *state, const struct ode_step *step, double theta, double *x)
{
    const struct tsit5 *d = state;
    size_t m = d->stride;
    const double *p = d->poly;
    for (size_t j = 0; j < (size_t)d->n; j++)
        x[j] = step->x[j] + theta * (p[j] + theta * (p[m + j] + theta * (p[2 * m + j] + theta * p[3 * m + j])));
}

const struct ode_method ode_tsit5 = {
    .name = "tsit5",
    .what = "explicit Runge-Kutta of order 5 (Tsitouras 5(4)), dense output of order 4",
    .order = 5,
    .error_order = 5,
    .cost = 6,
    .stable = STABILITY_LIMIT,
    .and_radau = "tsit5, radau",
    .alloc = tsit5_alloc,
    .free = tsit5_free,
    .attempt = tsit5_attempt,
    .dense_begin = tsit5_dense_begin,
    .stiff = tsit5_stiff,
    .dense_at = tsit5_dense_at,
};
