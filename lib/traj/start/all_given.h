/* Inside the traj folder: a start on the given equations, where the constraints have a further part. */
#ifndef SGA_TRAJ_ALL_GIVEN_H
#define SGA_TRAJ_ALL_GIVEN_H

#include "flow.h"

/* The independent constraints may vanish on more than all given equations do (two minors of a matrix of rank one,
 * where the third does not follow). x, a start on the constraints at which f->given fails, becomes the start of
 * the set of constraints and given equations together; false leaves it as it is. */
bool all_given_start(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                     double *x, double *moved);

#endif
