/* Inside the traj folder: a start on the component that the answer is about. */
#ifndef SGA_TRAJ_COMPONENT_START_H
#define SGA_TRAJ_COMPONENT_START_H

struct flow;
struct sga_solution;
struct sys_system;
struct traj_request;

/* The constraints of a set that is a union vanish on its other components too (x y = exp(x) - 1 is a curve and the line x = 0), and the point
 * nearest to the guess may lie on one of these, where the rank drops. x, such a start, which was moved from the guess, becomes the
 * nearest point that descent leads to from the component: from where the constraints solved variable by variable are at the guess, or from rq->on. Where the rank
 * drops there too, or nothing is found, x is left as it is. Costs nothing where the rank is as it should be but that rank. */
void component_start(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                     double *x, double *moved);

#endif
