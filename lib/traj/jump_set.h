/* Inside the traj folder: one event that sets variables, and the start after it. */
#ifndef SGA_TRAJ_JUMP_SET_H
#define SGA_TRAJ_JUMP_SET_H

#include "trajectory.h"

struct num_tape;

struct jump {
    const struct sys_system *sys; const struct sga_solution *sol; const struct traj_request *rq;   /* borrowed */
    int n, sets;
    struct num_tape *tape;        /* of variables, time; roots: what events set, in their order, then the events' functions */
    double *in, *out;
    int *variable;                /* by symbol of the store: its place, or -1 */
    unsigned char *moving;        /* n: some equation differentiates it */
    unsigned char *bound;         /* n: it is in some constraint */
    unsigned char *position;      /* n: its derivative is another variable */
};

/* What happened. */
struct jump_at {
    double t;
    const double *x;              /* n: before */
    const unsigned char *fired;   /* by event: it happens now */
    const signed char *crossing;  /* by event that happens: its direction */
    double wrong;                 /* what is set is made wrong by this part of it */
};

bool jump_init(struct jump *j, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err);
void jump_clear(struct jump *j);
/* x (n) after it, and by event the side of its zero from which the motion goes on (ode_problem.event_side), and whether its function stands at 0 there. What is set stays; of the rest moves as little as
 * will do: what no equation differentiates; then velocities but no positions (variables whose derivative is a variable, and those of constraints without a
 * set variable); then other variables than those of constraints without a set one. To the nearest point each time. */
bool jump_apply(struct jump *j, const struct jump_at *at, double *x, signed char *side, unsigned char *stands, struct sga_error *err);

#endif
