/* Inside the run folder: many trajectories of one analysis. */
#ifndef SGA_RUN_SWEEP_H
#define SGA_RUN_SWEEP_H

#include <stdbool.h>

struct job;
struct modes;
struct sga_solution;
struct sys_system;
struct traj_request;

/* What a set with events that set modes needs of the floor above: modes.h. */
struct sweep_modes {
    struct modes *of;            /* NULL: there are none */
    void (*set)(struct modes *m, int set, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq);
    void (*tell)(struct modes *m);
};

/* Runs the members of the request's sweep, everything but the start as in `request`, into
 * j->sweep; A member without a trajectory says why; false where the job cannot go on. */
bool answer_sweep(struct job *j, const struct sga_solution *solution, const struct traj_request *request, struct sweep_modes modes);

#endif
