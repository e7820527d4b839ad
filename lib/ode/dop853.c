/* Dormand-Prince 8(5,3): the explicit method for middle and high accuracy.
 *
 * Twelve stages give the step of order 8; two embedded formulas of order 5 and 3 are
 * combined to one error estimate that falls as h^8; three more stages give a polynomial
 * of order 7 over the step, asked for only where samples fall inside. Hairer, Norsett,
 * Wanner, Solving Ordinary Differential Equations I, II.5, II.6 and (stiffness) the
 * companion volume IV.2. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dop853_tables.h"
#include "larger.h"
#include "mem.h"
#include "rk_step.h"

/* Where the stability region ends on the negative real axis. */
#define STABILITY_LIMIT 6.1
/* See trusted. */
#define BELIEVED_FALL 0.3
#define MEMORY 0.5

enum { VECTORS = DOP853_ALL + 11 };

struct dop853 {
    int n;
    size_t even;      /* n, made even */
    size_t stride;    /* from one vector to the next */
    double *k;        /* DOP853_ALL vectors: the field at the stages */
    double *x;        /* the start of the step */
    double *y;        /* the state at the present stage */
    double *y_last;   /* the state at the last of the twelve stages */
    double *work;     /* a vector */
    double *poly;     /* 7 vectors: the polynomial's coefficients */
    struct sga_stages plan;
    double ratio;     /* of the estimates of order 5 and 3, over h^2, lately; its square */
};

static void *dop853_alloc(const struct ode_problem *p)
{
    struct dop853 *d = sga_malloc(sizeof *d);
    d->n = p->n;
    d->even = rk_even(p->n);
    d->stride = rk_stride(d->even);
    assert(d->stride % 2 == 0 && d->stride >= d->even);       /* pairs, of which none reaches into the next vector */
    d->ratio = 0;
    d->k = sga_calloc(VECTORS * d->stride + 1, sizeof *d->k);
    d->x = d->k + DOP853_ALL * d->stride;
    d->y = d->x + d->stride;
    d->y_last = d->y + d->stride;
    d->work = d->y_last + d->stride;
    d->poly = d->work + d->stride;
    d->plan = (struct sga_stages){.count = DOP853_STAGES, .c = dop853_c, .row = dop853_a, .stride = d->stride,
                                  .x = (size_t)(d->x - d->k), .y = (size_t)(d->y_last - d->k), .keep = DOP853_STAGES - 1};
    return d;
}

static void dop853_free(void *state)
{
    struct dop853 *d = state;
    free(d->k);
    free(d);
}

/* The state x + h sum_s a_s k_s, and the field there. */
RK_INLINE bool run_stage(struct dop853 *d, struct ode_field *field, const struct ode_step *step, int s, size_t stride,
                      double *y)
{
    for (size_t j = 0; j < d->even; j += 2)
        *(rk_two *)(y + j) = rk_stage(&dop853_a[s], step->h, d->x, d->k, stride, j);
    return ode_eval_stage(field, rk_time(step, dop853_c[s]), y, d->k + (size_t)s * stride);
}

/* e5 can pass through 0 by accident, most of all with few variables, and a step of any
 * error is then accepted. The ratio of the two estimates falls as h^2, so a ratio far
 * below that of the steps before, scaled, is such an accident, and is not believed. The square of the ratio that is
 * believed, times both. */
static double trusted(struct dop853 *d, double e5, double both, double h)
{
    double h4 = (h * h) * (h * h), least = sga_smaller(1, BELIEVED_FALL * BELIEVED_FALL * d->ratio * h4);
    d->ratio = sga_larger(MEMORY * MEMORY * d->ratio, e5 / (both * h4));       /* NaN is not kept */
    return sga_larger(e5, least * both);
}

/* |e5|^2 and |e3|^2 in units of what is allowed at x and `near`, and the increment. False: the values `near` are
 * larger than those at x and at the end. */
RK_INLINE bool norms(const struct dop853 *d, struct ode_step *step, size_t stride, const double *near, double *square5, double *square3)
{
    rk_two sum5 = {0, 0}, sum3 = {0, 0}, beyond = {0, 0};
    for (int j = 0; j < d->n; j += 2) {
        rk_two x = *(const rk_two *)(d->x + j), y = *(const rk_two *)(near + j);
        rk_two scale = 1 / rk_allowed(step->rtol, step->atol, rk_of(step->unit, d->n, j, 1), x, y);
        rk_two end = rk_pair(&dop853_a[DOP853_END], d->k, stride, (size_t)j), low = rk_pair(&dop853_weights3, d->k, stride, (size_t)j);
        rk_two dx = step->h * end;
        rk_two a5 = rk_pair(&dop853_error5, d->k, stride, (size_t)j) * scale, a3 = (end - low) * scale;
        sum5 += a5 * a5;
        sum3 += a3 * a3;
        beyond = rk_larger(rk_size(y) - 1.25 * rk_larger(rk_size(x), rk_size(x + dx)), beyond);
        step->dx[j] = dx[0];
        if (j + 1 < d->n)
            step->dx[j + 1] = dx[1];
    }
    *square5 = sum5[0] + sum5[1];
    *square3 = sum3[0] + sum3[1];
    return beyond[0] + beyond[1] == 0;
}

/* The increment, and the error estimate of both embedded formulas together:
 * |h| e5^2 / sqrt(e5^2 + 0.01 e3^2), root mean square over the variables. The next step waits for the error: what is
 * allowed is taken from the last stage's state instead of the end's, which it is near to, because it is known earlier. */
RK_INLINE void finish_step(struct dop853 *d, struct ode_step *step, size_t stride)
{
    double e5, e3;
    if (!norms(d, step, stride, d->y_last, &e5, &e3)) {
        for (int j = 0; j < d->n; j++)
            d->y[j] = step->x[j] + step->dx[j];
        norms(d, step, stride, d->y, &e5, &e3);
    }
    double both = e5 + 0.01 * e3, size = fabs(step->h), q = size * trusted(d, e5, both, step->h), whole = both * d->n;
    step->error = both != 0 ? q / sqrt(whole) : 0;
    step->log_error = ode_rough_log(q) - 0.5 * ode_rough_log(whole);
}

RK_INLINE void run_one_by_one(struct dop853 *d, const struct ode_field *field, const struct ode_step *step, size_t stride,
                              const struct ode_code *code)
{
#pragma GCC unroll 12
    for (int s = 1; s < DOP853_STAGES; s++) {
        double *y = s == DOP853_STAGES - 1 ? d->y_last : d->y, *k = d->k + (size_t)s * stride;
        for (size_t j = 0; j < d->even; j += 2)
            *(rk_two *)(y + j) = rk_stage(&dop853_a[s], step->h, d->x, d->k, stride, j);
        *code->time = rk_time(step, dop853_c[s]);
        code->run(code->slots, k, code->rest + (size_t)(s - 1) * code->rests, y);
        ode_step_aside(field, k);
    }
}

/* The twelve stages by the field's plain code. False: that does not hold here. */
RK_INLINE bool run_by_code(struct dop853 *d, struct ode_field *field, const struct ode_step *step, size_t stride)
{
    if (!rk_as_one(&d->plan, field, step, d->k)) {
        struct ode_code code;
        if (!field->p->code || !field->p->code(field->p->ctx, &code))
            return false;
        run_one_by_one(d, field, step, stride, &code);
    }
    return rk_holds(field, d->k, DOP853_STAGES, d->even, stride);
}

RK_INLINE enum ode_outcome attempt_with(struct dop853 *d, struct ode_field *field, struct ode_step *step, size_t stride)
{
    for (int j = 0; j < d->n; j += 2) {
        *(rk_two *)(d->k + j) = rk_of(step->f, d->n, j, 0);
        *(rk_two *)(d->x + j) = rk_of(step->x, d->n, j, 0);
    }
    if (run_by_code(d, field, step, stride)) {
        finish_step(d, step, stride);
        return ODE_STEPPED;
    }
#pragma GCC unroll 12
    for (int s = 1; s < DOP853_STAGES; s++)
        if (!run_stage(d, field, step, s, stride, s == DOP853_STAGES - 1 ? d->y_last : d->y))
            return ODE_FIELD_REFUSED;
    finish_step(d, step, stride);
    return ODE_STEPPED;
}

static enum ode_outcome dop853_attempt(void *state, struct ode_field *field, struct ode_step *step)
{
    struct dop853 *d = state;
    enum ode_outcome o = d->stride == RK_NEAR ? attempt_with(d, field, step, RK_NEAR) : attempt_with(d, field, step, d->stride);
    step->dense_error = step->doubt = step->error;
    step->error_order = 8;
    step->cost = DOP853_STAGES;
    return o;
}

static void dop853_forget(void *state)
{
    struct dop853 *d = state;
    d->ratio = 0;
}

/* Both the last stage and the end belong to the time t + h: the field's difference over
 * the states' is an eigenvalue estimate. */
static bool dop853_stiff(const void *state, const struct ode_step *step)
{
    const struct dop853 *d = state;
    const double *k = d->k + (DOP853_STAGES - 1) * d->stride;
    return rk_stiff(step->n, step->unit, step->h, step->f1, k, step->x1, d->y_last, STABILITY_LIMIT);
}

static bool dop853_dense_begin(void *state, struct ode_field *field, struct ode_step *step)
{
    struct dop853 *d = state;
    size_t m = d->stride;
    double h = step->h;
    for (int j = 0; j < d->n; j++)
        d->k[DOP853_END * m + (size_t)j] = step->f1[j];
    for (int s = DOP853_END + 1; s < DOP853_ALL; s++)
        if (!run_stage(d, field, step, s, m, d->y))
            return false;
    for (int j = 0; j < d->n; j++) {
        double rise = step->x1[j] - step->x[j];
        d->poly[j] = rise;
        d->poly[m + (size_t)j] = h * step->f[j] - rise;
        d->poly[2 * m + (size_t)j] = 2 * rise - h * (step->f[j] + step->f1[j]);
    }
    for (size_t r = 3; r < 7; r++) {
        rk_sum(&dop853_dense[r - 3], d->k, d->even, m, d->poly + r * m);
        for (size_t j = 0; j < d->even; j++)
            d->poly[r * m + j] *= h;
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
            s = (s + d->poly[(size_t)r * d->stride + (size_t)j]) *
                (r % 2 ? 1 - theta : theta);
        x[j] = step->x[j] + s;
    }
}

const struct ode_method ode_dop853 = {
    .name = "dop853",
    .what = "explicit Runge-Kutta of order 8 (Dormand-Prince 8(5,3)), dense output of order 7",
    .order = 8,
    .error_order = 8,
    .cost = 12,
    .stable = STABILITY_LIMIT,
    .and_radau = "dop853, radau",
    .alloc = dop853_alloc,
    .free = dop853_free,
    .attempt = dop853_attempt,
    .forget = dop853_forget,
    .dense_begin = dop853_dense_begin,
    .stiff = dop853_stiff,
    .dense_at = dop853_dense_at,
};
