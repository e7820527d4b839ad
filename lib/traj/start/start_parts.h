/* Inside the traj folder: the start of a system whose constraints are of several parts that have no variable in common: each by itself, so that it is the same whatever else is
 * in the system. */
#ifndef SGA_TRAJ_START_PARTS_H
#define SGA_TRAJ_START_PARTS_H

#include <stdbool.h>

struct flow;
struct sga_solution;
struct sys_system;
struct traj_request;

/* False: the constraints are of one part, or a part has no start by itself (x is then undefined). *moved: as consistent_start's. */
bool start_parts(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double *x, double *moved);

#endif
