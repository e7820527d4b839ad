/* Inside the traj folder: the arithmetic of a motion. Double is tried where it may reach the tolerances; double-double where it cannot, where
 * rounding shows, and where it is asked for; the better of two motions is kept. */
#ifndef SGA_TRAJ_ARITHMETIC_H
#define SGA_TRAJ_ARITHMETIC_H

#include <stdbool.h>

struct flow;
struct sga_error;
struct sga_solution;
struct sys_system;
struct traj_request;
struct traj_result;

/* From r->initial (n), r->moved and nothing else in r, with the flow's field ready: the motion in the arithmetic asked for (double,
 * double-double), or in the cheapest that reaches the tolerances. False with err, NOT_SUPPORTED where the one asked for is not possible. */
bool in_arithmetic(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                   struct traj_result *r, struct sga_error *err);

#endif
