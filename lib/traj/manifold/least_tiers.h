/* Inside the traj folder: derivatives of a start in tiers (tiers.h). Of points that are found tier by tier those of each tier are held in the next ones. */
#ifndef SGA_TRAJ_LEAST_TIERS_H
#define SGA_TRAJ_LEAST_TIERS_H

#include "least_rows.h"

struct sizes;
struct sys_system;
struct traj_request;

struct least_tiers {
    struct least_rows *rows;
    const struct sys_system *sys;
    const struct sizes *sizes;
    const struct traj_request *rq;   /* that the start was found with; its initial values are not looked at: */
    double t;
    const double *tau;               /* by direction: what time moves by, or NULL */
    const double *asked, *x;         /* what the start was looked for from, and the start */
};

/* y (directions x n): derivatives of `asked` become those of x, of directions that are not done and are told: how many. Cost: some solutions of as many
 * equations as there are variables and constraints, and as many Jacobians, for each direction. */
int least_tiers_move(const struct least_tiers *s, double *y, unsigned char *done);
/* s (n): a step of Newton's method from x to the start. False: it is not told. */
bool least_tiers_newton(const struct least_tiers *of, double *s);

#endif
