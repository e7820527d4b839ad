/* Inside the traj folder: consistent initial values. */
#ifndef SGA_TRAJ_CONSISTENT_H
#define SGA_TRAJ_CONSISTENT_H

#include "manifold.h"
#include "sizes.h"
#include "trajectory.h"

/* x becomes the point of the final set nearest to rq->initial at rq->start, in the norm
 * whose unit for variable j is max(1, |initial_j| / 100), its natural size in the place of 1
 * where that is far from it (sizes.h). Held values stay. Values that were not
 * given are free to move: if they alone can satisfy the constraints, the given ones stay.
 * elsewhere: some point of the set, a start of last resort, or NULL. *moved: the scaled
 * distance over which given values moved. False: INITIAL, naming the constraint that stays
 * unsatisfied and by how much. */
bool consistent_start(struct manifold *m, const struct sys_system *sys, const struct sga_solution *sol,
                      const struct sizes *sizes, const struct traj_request *rq, const double *elsewhere, double *x, double *moved, struct sga_error *err);

#endif
