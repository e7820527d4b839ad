/* Inside the traj folder: motions on which a variable grows without bound while all else stays where the constraints are regular. */
#ifndef SGA_TRAJ_ENDINGS_FAR_H
#define SGA_TRAJ_ENDINGS_FAR_H

#include <stdbool.h>

struct flow;
struct traj_request;
struct traj_result;

/* The motion of f ended where a pivot of the reduction tends to 0, or by a rank. Where a variable that equations determine without derivatives has
 * become far larger than it was, and the rows determine the velocities of the others there as elsewhere, no place of the set is lost, since none is
 * reached: u in u (x - 1) = 1 as x tends to 1. (Multipliers, which grow at a dead centre too, are none of these.) The reason is `blow_up` then, of
 * that variable. False, and nothing is changed: it is not so. Costs one evaluation of the rows and an elimination. */
bool endings_far(struct flow *f, const struct traj_request *rq, struct traj_result *r);

#endif
