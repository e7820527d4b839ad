/* Inside the traj folder: functions of time alone in the equations (inputs), looked at before the motion, so that no
 * step is longer than what they do where it leads. */
#ifndef SGA_TRAJ_INPUTS_H
#define SGA_TRAJ_INPUTS_H

#include "trajectory.h"

struct inputs {
    struct ode_piece *piece;   /* in the order of the motion; see ode_problem */
    int count;
    bool complete;             /* everywhere; else the work ran out: narrow pulses may be left unseen */
};

/* Those among roots, tables left out, between the request's start and its last time. Nothing is done where nothing
 * depends on time in such a way. Cost: 10 microseconds for each piece and each ten operations, at most about 50 ms. */
void inputs_examine(struct inputs *q, const struct sys_system *sys, const struct traj_request *rq, const expr_id *root, int roots);
void inputs_clear(struct inputs *q);

#endif
