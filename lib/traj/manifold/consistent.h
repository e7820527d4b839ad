/* Inside the traj folder: consistent initial values. */
#ifndef SGA_TRAJ_CONSISTENT_H
#define SGA_TRAJ_CONSISTENT_H

#include "trajectory.h"

struct manifold;
struct sizes;

/* x becomes the point of the final set nearest to rq->initial at rq->start, tier by tier (tiers.h), in the norm
 * whose unit for variable j is max(1, |initial_j| / 100), its natural size in the place of 1
 * where that is far from it (sizes.h). Held values stay. elsewhere: some point of the set, a start of last resort, or NULL.
 * *moved: the scaled distance over which given values moved. False: INITIAL, naming the constraint that stays
 * unsatisfied and by how much. Large systems (dense steps would be dear): tiers_large_start, and consistent_large where that finds none. */
bool consistent_start(struct manifold *m, const struct sys_system *sys, const struct sga_solution *sol,
                      const struct sizes *sizes, const struct traj_request *rq, const double *elsewhere, double *x, double *moved, struct sga_error *err);

/* Of the values that were given, in units of scale. */
double consistent_moved(const struct manifold *m, const struct traj_request *rq, const double *scale, const double *x);
/* consistent_large.c. With sparse steps: values that were not given adapt first; otherwise the nearest point for the given ones, the
 * others nearly free. False: none was found. */
bool consistent_large(struct manifold *m, const struct sizes *sizes, const struct traj_request *rq, const double *elsewhere, double *x);

/* err: a value at the start is larger than doubles are. Returns false. */
bool consistent_too_large(struct sga_error *err);

#endif
