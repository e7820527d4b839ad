/* Inside the traj folder: in double-double, what jumps where equations differentiate sums of variables (leap.h). */
#ifndef SGA_TRAJ_PRECISE_LEAP_H
#define SGA_TRAJ_PRECISE_LEAP_H

#include "precise.h"

/* x (n), whose constraints have jumped, moves to where the ramp of leap_over ends, which double found near `found` (n). False, and x as it was: that point
 * is not found to all digits. Dense. Cost: some hundred to some thousand eliminations in double-double. */
bool precise_leap(struct precise *p, num_dd t, num_dd *x, const double *found);

#endif
