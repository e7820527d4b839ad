/* Inside the run folder: many trajectories of one analysis. */
#ifndef SGA_RUN_SWEEP_H
#define SGA_RUN_SWEEP_H

#include "answer.h"

/* Runs the members of the request's sweep, everything but the start as in `request`, into
 * j->trajectories. A member without a trajectory says why; false where the job cannot go on. */
bool answer_sweep(struct job *j, const struct sga_solution *solution, const struct traj_request *request);
/* The members of an object that is open, and its end: those of j->trajectory. */
bool answer_write_motion(struct job *j, struct sga_json *w);

#endif
