/* Inside the traj folder: a motion in pieces passes a singular position. */
#ifndef SGA_TRAJ_JUMP_OVER_H
#define SGA_TRAJ_JUMP_OVER_H

#include "jump_joined.h"

struct jump;

/* Events that set, and places passed, in one motion. */
enum { JUMP_MOST = 20000 };

/* The piece of q, in j, ended at a singular position: the samples around it, and where the next piece begins (*t, and what q says). False: the motion ends there. */
bool jump_over(struct jump_pass *p, struct jump_piece *q, const struct jump *j, const struct traj_request *rq, const struct traj_result *piece, double *t);

#endif
