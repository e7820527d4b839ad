/* Inside the traj folder: what derivatives of a motion do where it turns a switch (variation.h). */
#ifndef SGA_TRAJ_VARIATION_TURN_H
#define SGA_TRAJ_VARIATION_TURN_H

#include <stdbool.h>

struct flow;
struct num_jacobian;
struct num_tape;
struct sga_error;
struct traj_request;

struct variation_turn {
    int base, directions;
    int *surface_of;              /* by switch of the field: its surface among traj_turns', or -1 */
    int surfaces;
    struct num_tape *surface;     /* roots: the surfaces; inputs: variables, time */
    struct num_jacobian *jac;     /* by variables and time */
    struct num_tape *slope;       /* roots: surfaces x directions */
    double *value, *along, *before, *after;
};

/* Ready for rq->turns, the field of the flow being ready. */
bool variation_turn_init(struct variation_turn *v, const struct flow *f, const struct traj_request *rq, struct sga_error *err);
void variation_turn_clear(struct variation_turn *v);
/* As ode_problem.turned. */
bool variation_turned(void *flow, double t, const double *from, const double *before, const unsigned char *turned, double *x);

#endif
