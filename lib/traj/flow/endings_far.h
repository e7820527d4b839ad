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
/* The motion tends to a zero of the pivot, which depends on a variable that grows without bound as it does so (x y + 1 as x tends to 0 and y to infinity): no place
 * of the set is lost. The reason is `blow_up` then, of that variable. False, and nothing is changed: it is not so. */
bool endings_grows_with(struct flow *f, const struct traj_request *rq, int pivot, struct traj_result *r);
/* The motion ended by a rank where no pivot that can be 0 is near it: something tends to 0 that is 0 nowhere (exp(y) as y falls), and a derivative that it
 * divides grows without bound. The reason is `blow_up` then, of that variable; whether the gauge choice divides by what tends to 0, the caller adds. False, and nothing is changed: it is not so. */
bool endings_steep(struct flow *f, const struct traj_request *rq, struct traj_result *r);
/* Of the way made: with tight tolerances corrections are roundings as soon as a hundredth of a pivot is left. */
#define ENDINGS_NEAR 1e-2
/* The pivot tends to 0 where the motion ended: that is when, if it is so near (of the way made), and not before the last row. */
void endings_at_zero(struct flow *f, const struct traj_request *rq, int pivot, double near, struct traj_result *r);

#endif
