/* Step-size control; see the header. */
#include "control.h"

#include <math.h>

#define SAFETY 0.9
#define INTEGRAL_GAIN 0.04     /* 0 would be the plain controller */
#define SHRINK_MOST (1.0 / 3)
#define GROW_MOST 6.0
#define LEAST_LOG (-9.2103403719761827)   /* log 1e-4 */

void ode_control_begin(struct ode_control *c, double error_order)
{
    *c = (struct ode_control){error_order, LEAST_LOG, 0, false};
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
    factor *= SAFETY;
    factor = factor < SHRINK_MOST ? SHRINK_MOST : factor > GROW_MOST ? GROW_MOST : factor;
    if (c->refused_before && factor > 1)
        factor = 1;
    c->log_before = now > LEAST_LOG ? now : LEAST_LOG;
    c->step_before = step;
    c->refused_before = false;
    return factor;
}

double ode_control_refused(struct ode_control *c, double error)
{
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

double ode_first_step(struct ode_field *field, const struct ode_step *s, double error_order,
                      double *work)
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
    return fmin(fmin(100 * h, next), span);
}
