/* Taylor series: the explicit method for high accuracy.
 *
 * The coefficients of the solution at the present point come from the problem, of an order
 * that the tolerance sets (Jorba and Zou, Experimental Mathematics 14, 2005: the work to go a
 * given way is least near order -ln(tolerance)/2 + 1; as each step has a price of its own,
 * somewhat more measures best here). The step is the longest over which the
 * last terms stay within the tolerance: the series itself says how far, so the driver's
 * proposal is only an upper bound, and no step is computed in vain. The polynomial is the
 * dense output, of the same order.
 *
 * Last terms can vanish where the solution does not end (x' = t^30 at 0), so each step also
 * compares the polynomial's derivative at its end with the field there. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "control.h"
#include "larger.h"
#include "mem.h"
#include "method.h"

#define LEAST_ORDER 6
#define MOST_ORDER 36
/* Terms are expected to fall by this from each to the next at the end of a step. */
#define EXPECTED_FALL 0.2
#define LAST_TERMS 3
/* The error of a step by its last terms, in units of that allowed: other methods' steps err by less than they are
 * estimated to, while here terms say quite exactly what is left out, so that it has to be asked for. */
#define STRICT 0.02
/* Longer steps than the terms allow are of no use, shorter ones cost. */
#define SAFETY 0.95
/* The end of the series is passed by this part of a step, so that the next begins beyond. */
#define BEYOND 1e-13
#define GROWTH 6.0
#define SCALES 3               /* tries of a scale on which the series is finite */
/* A defect where the terms say that all is well is a sign of stiffness (the polynomial is so
 * near to fast components that the field answers loudly): so many steps grow slowly then. */
#define CAUTION 4
#define SLOW_GROWTH 1.1
#define FIRST 2                /* the order whose term is compared with the next but one, */
#define RISE 1e3               /* as the last but two with the last: squares of their ratios */

struct taylor {
    int n, order;
    double *series;            /* (order + 1) x n, with s = 1 at t + scale */
    double scale, reach;
    double t, t_low;           /* where they belong to; the state is their first row */
    bool known;
    double *part, per_n;       /* n: 1 / the error allowed in this step; 1 / n */
    double *end, *f, *slope;   /* n: the state, the field and the polynomial's at the end of a step */
    double term[LAST_TERMS];   /* see last_terms */
    int cautious;              /* steps to come */
    bool rising;               /* see rises */
};

static void *taylor_alloc(const struct ode_problem *p)
{
    struct taylor *w = sga_calloc(1, sizeof *w);
    w->n = p->n;
    w->per_n = 1.0 / (p->n ? p->n : 1);
    w->series = sga_calloc((MOST_ORDER + 5) * (size_t)p->n + 1, sizeof *w->series);
    w->end = w->series + (MOST_ORDER + 1) * (size_t)p->n;
    w->f = w->end + p->n;
    w->slope = w->f + p->n;
    w->part = w->slope + p->n;
    return w;
}

static void taylor_free(void *state)
{
    struct taylor *w = state;
    free(w->series);
    free(w);
}

static void taylor_forget(void *state)
{
    ((struct taylor *)state)->known = false;
}

static int order_for(const struct ode_step *step)
{
    double tol = fmax(step->rtol, DBL_EPSILON);
    if (!(step->rtol > 0))
        tol = fmin(1e-3, fmax(step->atol, DBL_EPSILON));
    /* Another order for each factor of ten: solutions that are compared may take the same steps, and must differ even so.
     * Even always: nor may they differ in whether it is the odd terms or the even ones that are left out, of which a
     * projection may remove the one sort. */
    int order = 2 * (int)ceil(-log10(tol) - 0.01) + 4;
    return order < LEAST_ORDER ? LEAST_ORDER : order > MOST_ORDER ? MOST_ORDER : order;
}

static void weigh(struct taylor *w, const struct ode_step *step)
{
    for (int j = 0; j < w->n; j++)
        w->part[j] = 1 / ode_allowed(step->rtol, step->atol, step->unit[j], step->x[j], step->x[j]);
}

/* Root mean square of v in units of the error allowed; v may be so large that squares overflow. */
static double weighted(const struct taylor *w, const double *v)
{
    double most = 0, sum = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int j = 0; j < w->n; j++) {
            double a = fabs(v[j]) * w->part[j];
            most = pass ? most : fmax(most, a);
            sum += pass ? (a / most) * (a / most) : 0;
        }
        if (!(most > 0) || isinf(most))
            return most;
    }
    return most * sqrt(sum / w->n);
}

static bool same_place(const struct taylor *w, const struct ode_step *step)
{
    return w->known && w->t == step->t && w->t_low == step->t_low && w->scale * step->h > 0 &&
           fabs(step->h) > 1e-4 * fabs(w->scale) && fabs(step->h) <= 1e8 * fabs(w->scale) &&
           memcmp(w->series, step->x, (size_t)w->n * sizeof *step->x) == 0;
}

/* The coefficients at the step's start, on a scale near its size, or below where they overflow there. */
static bool expand(struct taylor *w, struct ode_field *field, struct ode_step *step)
{
    int e;
    w->order = order_for(step);
    step->cost = 1;
    if (same_place(w, step))
        return true;
    frexp(step->h, &e);
    w->t = step->t;
    w->t_low = step->t_low;
    w->known = false;
    const struct ode_problem *p = field->p;
    for (int turn = 0; turn < SCALES && !w->known; turn++, e -= 8) {
        w->scale = copysign(ldexp(1, e), step->h);
        field->stats->evaluations += w->order;
        step->cost += w->order;
        w->known = p->taylor(p->ctx, step->t + step->t_low, step->x, w->order, w->scale, w->series, &w->reach);
    }
    for (int k = 1; k <= w->order && w->known && field->beside; k++)
        for (int j = 0; j < w->n; j++)
            w->series[(size_t)k * (size_t)w->n + (size_t)j] *= ode_aside(field, j);
    if (!w->known)
        field->why = p->why ? p->why(p->ctx) : ODE_LEFT_DOMAIN;
    return w->known;
}

/* The mean square of v in units of the error allowed, where squares neither over- nor underflow; else -1. */
static double mean_square(const struct taylor *w, const double *v)
{
    double sum = 0;
    for (int j = 0; j < w->n; j++) {
        double a = v[j] * w->part[j];
        sum += a * a;
    }
    return sum > 1e-200 && sum < 1e200 ? sum * w->per_n : -1;
}

/* The last terms at s = 1, the earlier ones taken on by the fall expected. Returns up to which s
 * they are within tolerance. */
static double last_terms(struct taylor *w)
{
    double fall = EXPECTED_FALL, most = -500;
    for (int i = 0; i < LAST_TERMS; i++, fall *= EXPECTED_FALL) {
        int k = w->order - i;
        const double *last = w->series + (size_t)k * (size_t)w->n;
        double square = mean_square(w, last);
        w->term[i] = fall * (square > 0 ? sqrt(square) : weighted(w, last));
        most = sga_larger(most, ode_rough_log(w->term[i] * (1 / STRICT)) / k);
    }
    return ode_rough_power(-most);
}

/* The last coefficients fall more slowly than the first ones, by far: it is fast components as small as roundings that end
 * the step, a sign of stiffness. (Other terms fall about alike, or ever faster.) */
static bool rises(const struct taylor *w)
{
    size_t n = (size_t)w->n, last = (size_t)w->order;
    double first = mean_square(w, w->series + FIRST * n), before = mean_square(w, w->series + (last - 2) * n);
    return first > 0 && before > 0 &&
           mean_square(w, w->series + last * n) * first > RISE * before * mean_square(w, w->series + (FIRST + 2) * n);
}

/* The error of a step to s. */
static double error_at(const struct taylor *w, double s)
{
    double most = 0, power = 1, base = s;
    for (unsigned k = (unsigned)(w->order - LAST_TERMS + 1); k; k >>= 1, base *= base)
        power *= k & 1 ? base : 1;
    for (int i = LAST_TERMS - 1; i >= 0; i--, power *= s)
        most = sga_larger(most, w->term[i] * power);
    return most;
}

/* Two variables at a time, of any address. */
typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));

/* The polynomial less its first term at s, and (where slope is not NULL) the field that it says. Even and odd terms apart, so
 * that no long chain waits for itself; the second variable of the last pair is the first of the next row, or what follows
 * the series, where n is odd. */
static void evaluate(const struct taylor *w, double s, double *dx, double *slope)
{
    size_t n = (size_t)w->n, order = (size_t)w->order;
    double q = s * s, part = 1 / w->scale;
    pair q2 = {q, q};
    for (size_t j = 0; j < n; j += 2) {
        const double *c = w->series + order * n + j;
        pair even = {0}, odd = {0}, rise = {0}, fall = {0};     /* of the terms from 2 on; and times their orders */
        double k = (double)order;
        if (order % 2) {
            odd = *(const pair *)c;
            fall = odd * (pair){k, k};
            c -= n;
            k--;
        }
        for (; k > 3; k -= 2, c -= 2 * n) {
            pair a = *(const pair *)c, b = *(const pair *)(c - n);
            even = even * q2 + a;
            odd = odd * q2 + b;
            rise = rise * q2 + a * (pair){k, k};
            fall = fall * q2 + b * (pair){k - 1, k - 1};
        }
        pair a = *(const pair *)c, b = *(const pair *)(c - n);
        even = even * q2 + a;
        rise = rise * q2 + a * (pair){2, 2};
        odd = b * (pair){s, s} + q2 * (even + odd * (pair){s, s});
        fall = (b + ((pair){s, s} * rise + q2 * fall)) * (pair){part, part};
        dx[j] = odd[0];
        if (slope)
            slope[j] = fall[0];
        if (j + 1 == n)
            break;
        dx[j + 1] = odd[1];
        if (slope)
            slope[j + 1] = fall[1];
    }
}

/* How the polynomial's derivative at the end misses the field there, in units of the error that
 * the step may make; a miss of the size of roundings is none. */
static bool defect(struct taylor *w, struct ode_field *field, const struct ode_step *step, double *miss)
{
    for (int j = 0; j < w->n; j++)
        w->end[j] = step->x[j] + step->dx[j];
    if (!ode_eval(field, step->t + (step->t_low + step->h), w->end, w->f))
        return false;
    double misses = 0, sizes = 0;
    for (int j = 0; j < w->n; j++) {
        double size = w->f[j] * w->part[j], a = w->slope[j] * w->part[j] - size;
        misses += a * a;
        sizes += size * size;
    }
    double h = fabs(step->h);
    if (!(misses < 1e200 && sizes < 1e200 && (misses > 1e-200 || misses == 0))) {     /* squares over- or underflow */
        for (int j = 0; j < w->n; j++)
            w->slope[j] -= w->f[j];
        misses = h * weighted(w, w->slope);
        sizes = h * weighted(w, w->f);
    } else {
        misses = h * sqrt(misses * w->per_n);
        sizes = h * sqrt(sizes * w->per_n);
    }
    *miss = sga_larger(0, misses - ODE_FIELD_ROUNDING * DBL_EPSILON * sizes) / (w->order + 1);
    return true;
}

static enum ode_outcome taylor_attempt(void *state, struct ode_field *field, struct ode_step *step)
{
    struct taylor *w = state;
    double miss;
    if (!expand(w, field, step))
        return ODE_FIELD_REFUSED;
    weigh(w, step);
    double s = step->h / w->scale, far = fmin(fmin(1, SAFETY * last_terms(w)), w->reach + BEYOND);
    if (far < s) {
        s = far;
        step->h = s * w->scale;
    }
    assert(s > 0 && s <= 1 + BEYOND);       /* where the series was asked for */
    evaluate(w, s, step->dx, w->slope);
    if (!defect(w, field, step, &miss))
        return ODE_FIELD_REFUSED;
    if (miss > 1)
        w->cautious = CAUTION;
    step->error = step->dense_error = step->doubt = fmax(error_at(w, s), miss);
    step->error_order = w->order;
    w->rising = rises(w);
    step->f_end = w->f;
    return ODE_STEPPED;
}

/* How far the next step may go is seen when its series is known: the driver need only allow
 * enough. */
static double taylor_accepted(void *state, const struct ode_step *step, double factor)
{
    struct taylor *w = state;
    (void)step;
    (void)factor;
    if (!w->cautious)
        return GROWTH;
    w->cautious--;
    return SLOW_GROWTH;
}

static bool taylor_stiff(const void *state, const struct ode_step *step)
{
    (void)step;
    return ((const struct taylor *)state)->cautious > 0 || ((const struct taylor *)state)->rising;
}

static bool taylor_dense_begin(void *state, struct ode_field *field, struct ode_step *step)
{
    (void)state;
    (void)field;
    (void)step;
    return true;
}

static void taylor_dense_at(const void *state, const struct ode_step *step, double theta, double *x)
{
    const struct taylor *w = state;
    evaluate(w, theta * step->h / w->scale, x, NULL);
    for (int j = 0; j < w->n; j++)
        x[j] += step->x[j];
}

struct ode_series ode_taylor_series(const void *state)
{
    const struct taylor *w = state;
    return (struct ode_series){ w->order, w->scale, w->series, w->slope, w->f };
}

const struct ode_method ode_taylor = {
    .name = "taylor",
    .what = "Taylor series, order and step from the tolerance, dense output of the same order",
    .series = true,
    .order = MOST_ORDER,
    .error_order = LEAST_ORDER,
    .alloc = taylor_alloc,
    .free = taylor_free,
    .attempt = taylor_attempt,
    .accepted = taylor_accepted,
    .forget = taylor_forget,
    .dense_begin = taylor_dense_begin,
    .stiff = taylor_stiff,
    .dense_at = taylor_dense_at,
};
