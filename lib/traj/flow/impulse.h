/* Inside the traj folder: constraints that jump where nothing can follow.
 *
 * Where a switch turns, constraints may jump. What no equation differentiates is solved for anew (manifold_jump), the rest is continuous: where the
 * jump is in what the rest has to satisfy (an input that jumps in a constraint which was differentiated), velocities or positions would have to
 * jump, and what is solved for their derivatives would be an impulse. */
#ifndef SGA_TRAJ_IMPULSE_H
#define SGA_TRAJ_IMPULSE_H

#include "flow.h"

/* Of a motion that ended after its last point f->field->home because the constraints could not be met: whether a switch turns there and
 * the constraints jump by what only variables that some equation differentiates could take up. *t: when, moved to that time; *constraint: the one that jumps
 * most, *jump: by how much. Cost: constraints squared times variables, once. */
bool impulse_at_end(struct flow *f, double *t, int *constraint, double *jump);

#endif
