/* Step-size control; see the header. */
#include "control.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "method.h"

#define SAFETY 0.9
#define INTEGRAL_GAIN 0.04     /* 0 would be the plain controller */
#define SHRINK_MOST (1.0 / 3)
#define GROW_MOST 6.0
#define LEAST_LOG (-9.2103403719761827)   /* log 1e-4 */
#define LEAST (-33.219280948873624)       /* the logarithm of 1e-10 to base 2 */
#define LOG_2 0.69314718055994531

void ode_control_begin(struct ode_control *c, double error_order)
{
    *c = (struct ode_control){error_order, LEAST_LOG, 0, false};
}

/* What both controllers agree on, within bounds; the step is remembered. */
static double bounded(struct ode_control *c, double factor, double now, double step)
{
    factor *= SAFETY;
    factor = factor < SHRINK_MOST ? SHRINK_MOST : factor > GROW_MOST ? GROW_MOST : factor;
    if (c->refused_before && factor > 1)
        factor = 1;
    assert(factor > 0);      /* is a number: any other would be tried for ever */
    c->log_before = now > LEAST_LOG ? now : LEAST_LOG;
    c->step_before = step;
    c->refused_before = false;
    return factor;
}

double ode_control_accepted(struct ode_control *c, double error, double step)
{
    double now = log(error > 1e-10 ? error : 1e-10), before = c->log_before;
    double power = 1.0 / c->error_order - 0.2 * INTEGRAL_GAIN;
    double factor = exp(INTEGRAL_GAIN * before - power * now);
    if (c->step_before > 0) {
        double trend = exp((before - 2 * now) / c->error_order) * step / c->step_before;
        factor = trend < factor ? trend : factor;
    }
    return bounded(c, factor, now, step);
}

/* The nearest whole power by the rounding of a sum, and a cubic for the rest. */
double ode_rough_power(double x)
{
    double shifted = x + 0x1.8p52, f = x - (shifted - 0x1.8p52);
    double part = (1 + f * 0.69328) + (f * f) * (0.24221 + f * 0.05501);
    uint64_t whole, bits;
    memcpy(&whole, &shifted, sizeof whole);
    memcpy(&bits, &part, sizeof bits);
    bits += whole << 52;
    memcpy(&part, &bits, sizeof part);
    return part;
}

double ode_control_quick(struct ode_control *c, double log_error, double step)
{
    double now = log_error > LEAST ? log_error : LEAST, before = c->log_before * (1 / LOG_2), part = 1.0 / c->error_order;
    double rise = INTEGRAL_GAIN * before - (part - 0.2 * INTEGRAL_GAIN) * now;
    if (c->step_before > 0) {
        double trend = (before - 2 * now) * part + ode_rough_log(step / c->step_before);
        rise = trend < rise ? trend : rise;
    }
    return bounded(c, ode_rough_power(rise), now * LOG_2, step);
}

double ode_control_refused(struct ode_control *c, double error)
{
    assert(!(error <= 1));       /* else why was it refused */
    c->refused_before = true;
    double factor = SAFETY * pow(error, -1.0 / c->error_order);
    return factor > SHRINK_MOST ? fmin(factor, SAFETY) : SHRINK_MOST;
}

static double weighted(const struct ode_step *s, const double *v, const double *minus)
{
    double sum = 0;
    for (int j = 0; j < s->n; j++) {
        double a = v[j] - (minus ? minus[j] : 0);
        a /= ode_allowed(s->rtol, s->atol, s->unit[j], s->x[j], s->x[j]);
        sum += a * a;
    }
    return s->n ? sqrt(sum / s->n) : 0;
}

double ode_first_step(struct ode_field *field, const struct ode_step *s, double error_order, int level, double *work)
{
    double span = fabs(s->h), *x1 = work, *f1 = work + s->n;
    double dx = weighted(s, s->x, NULL), df = weighted(s, s->f, NULL), second = 0;
    double h = dx < 1e-5 || df < 1e-5 ? 1e-6 * span : 0.01 * dx / df;
    h = fmin(h, span);
    bool known = false;
    for (int turn = 0; turn < 8 && !known; turn++) {
        double signed_h = copysign(h, s->h);
        for (int j = 0; j < s->n; j++)
            x1[j] = s->x[j] + signed_h * s->f[j];
        known = ode_eval(field, s->t + signed_h, x1, f1);
        if (!known)
            h *= 0.1;
    }
    if (!known)
        return h;
    second = weighted(s, f1, s->f) / h;
    double most = fmax(df, second);
    double next = most <= 1e-15 ? fmax(1e-6 * span, 1e-3 * h)
                                : pow(0.01 / most, 1.0 / error_order);
    return fmin(fmin(ldexp(100 * h, -level), next), span);
}
