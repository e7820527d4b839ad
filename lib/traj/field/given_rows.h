/* Inside the traj folder: a start held against the equations without derivatives, as they were given. */
#ifndef SGA_TRAJ_GIVEN_ROWS_H
#define SGA_TRAJ_GIVEN_ROWS_H

#include "trajectory.h"

/* x is on the constraints as far as doubles tell. Constraints that are made of equations put into each other may have terms so large that
 * their roundings tell nothing; the equations themselves have their own size. False with err INITIAL: one of them is missed by far more than what it adds
 * up, and than what the search allows. Cost: their values and gradients, and a walk through those that are in doubt. */
bool given_rows_hold(const struct sys_system *sys, const struct traj_request *rq, const double *x, struct sga_error *err);

#endif
