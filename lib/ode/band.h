/* Where along a step arguments of exponentials came near to 0 (see band.c): for all marches, in whatever arithmetic. */
#ifndef SGA_ODE_BAND_H
#define SGA_ODE_BAND_H

#include <stdbool.h>

#include "guard.h"

/* Arguments along the step, at its ends, and their derivatives there by the part of the step that has passed (only looked at where both ends are on one
 * side). */
struct ode_band_way {
    const struct guard_way *way;
    const double *a, *a1, *rate, *rate1;
};

/* Whether some argument is away from 0 at both ends: 1: on two sides; 2: (also) on one, so that rates are needed. 0: none. */
int ode_band_outside(int count, const double *a, const double *a1);
/* Whether some may have been inside in between. */
bool ode_band_suspect(const struct ode_band_way *w);
/* The first place in (0, 1) where one was; 2: none. */
double ode_band_place(const struct ode_band_way *w);

#endif
