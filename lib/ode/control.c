/* Step-size control; see the header. */
#include "control.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define SAFETY 0.9
#define INTEGRAL_GAIN 0.04     /* 0 would be the plain controller */
#define SHRINK_MOST (1.0 / 3)
#define GROW_MOST 6.0
#define LEAST_LOG (-13.287712379549449)   /* of 1e-4 */

/* Logarithms to base 2 and powers of 2 to four digits, of normal numbers and powers between them: more than step
 * sizes need, in a fraction of the time, and by arithmetic alone. */
static double rough_log(double x)
{
    uint64_t bits, exponent;
    memcpy(&bits, &x, sizeof bits);
    exponent = (bits - 0x3FE6A09E00000000u) >> 52;       /* so that the rest is from sqrt 1/2 to sqrt 2 */
    bits -= exponent << 52;
    memcpy(&x, &bits, sizeof x);
    double s = (x - 1) / (x + 1), q = s * s;
    return (double)(int)((exponent ^ 0x800) - 0x800) + s * (2.8853900817779268 + q * 0.96179669392597560);
}

static double rough_exp(double x)
{
    x = x < -1000 ? -1000 : x > 1000 ? 1000 : x;
    int whole = (int)(x + 1024.5) - 1024;
    double y = (x - whole) * 0.69314718055994531;
    uint64_t bits = (uint64_t)(whole + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power * ((1 + y) + y * y * ((0.5 + y * (1.0 / 6)) + y * y * (1.0 / 24)));
}

void ode_control_begin(struct ode_control *c, double error_order)
{
    *c = (struct ode_control){error_order, LEAST_LOG, 0, false};
}

double ode_control_accepted(struct ode_control *c, double error, double step)
{
    double now = rough_log(error > 1e-10 ? error : 1e-10), before = c->log_before, part = 1.0 / c->error_order;
    double rise = INTEGRAL_GAIN * before - (part - 0.2 * INTEGRAL_GAIN) * now;
    if (c->step_before > 0) {
        double trend = (before - 2 * now) * part + rough_log(step / c->step_before);
        rise = trend < rise ? trend : rise;
    }
    double factor = SAFETY * rough_exp(rise);
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
