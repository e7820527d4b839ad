/* Natural sizes of a system's variables and of its time, where these lie far from 1 (a charge of 1e-15 C, a pendulum of 1e-9 m): what its
 * equations say of them. Terms of an equation should be of one size, arguments of functions near 1 (points/scaling.h). A guess: nothing
 * rests on it but where points are looked for, and what absolute tolerances are in units of (traj/sizes.h). */
#ifndef SGA_SGA_NATURAL_H
#define SGA_SGA_NATURAL_H

#include <stdbool.h>

struct scaling;
struct sys_system;

/* What rows and restrictions say, to which values that are known may be added. timed: time is an unknown too, after the variables. even:
 * all terms of a sum count alike (scaling_even). NULL: more than SCALING_MOST variables. The caller frees it. */
struct scaling *natural_scaling(const struct sys_system *sys, bool timed, bool even);

/* By variable, log2 of its size; NULL where all are near 1 or nothing is known. Velocities count as their variables; where the time over
 * which things change turns out far from 1, as these over that. *time_unit is that time, if equations have time at all and it is far from 1
 * (at times far beyond, exponentials of it have no size that could be computed with); otherwise 0. The caller frees it. */
int *natural_sizes(const struct sys_system *sys, double *time_unit);

#endif
