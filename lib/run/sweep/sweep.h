/* Inside the run folder: many trajectories of one analysis. */
#ifndef SGA_RUN_SWEEP_H
#define SGA_RUN_SWEEP_H

#include <stdbool.h>

struct job;
struct sga_solution;
struct traj_request;

/* Runs the members of the request's sweep, everything but the start as in `request`, into
 * j->sweep. A member without a trajectory says why; false where the job cannot go on. */
bool answer_sweep(struct job *j, const struct sga_solution *solution, const struct traj_request *request);

#endif
