/* Inside the traj folder: which variables are coordinates of the final set near a point. */
#ifndef SGA_TRAJ_COORDINATES_H
#define SGA_TRAJ_COORDINATES_H

#include "trajectory.h"

struct manifold;

/* solved[j] (n, zero on entry) becomes 1 for variables that the constraints can be solved for near x, as many as there are
 * independent constraints: multipliers and algebraic variables first, then velocities, then coordinates (sys/kinds.h), of each
 * those that were not given first; among these the one in which the constraints are steepest, and of two alike the later one
 * by name. The others are coordinates of the set. Dense, c^2 n: false, and nothing is said, where that is dear. */
bool coordinates_solved(struct manifold *m, const struct sys_system *sys, const struct traj_request *rq, const double *x, unsigned char *solved);

#endif
