/* What a number may be wrong by: the one rule that errors are compared with, in steps, estimates, events and reports.
 *
 *     allowed = atol * unit + rtol * |value|
 *
 * unit is the natural size of what is measured (1 where it has none), so that atol means the same in any units. */
#ifndef SGA_BASE_TOLERANCE_H
#define SGA_BASE_TOLERANCE_H

#include <math.h>

struct sga_tolerance { double rtol, atol; };

static inline double sga_allowed(struct sga_tolerance tolerance, double unit, double value)
{
    return tolerance.atol * unit + tolerance.rtol * fabs(value);
}

/* An error in units of what is allowed, which is taken as 1e-300 at the least: asked for exactly, any error counts. NaN is
 * infinite. */
static inline double sga_error_ratio(double error, struct sga_tolerance tolerance, double unit, double value)
{
    double allowed = sga_allowed(tolerance, unit, value), ratio = error / (allowed > 1e-300 ? allowed : 1e-300);
    return isnan(ratio) ? INFINITY : ratio;
}

#endif
