/* Inside the traj folder: motions of systems in which equations define variables by functions with switches or roots
 * (sga/definition.h). What moves is the rest, with the functions in their places: a value at a kink or at the argument 0 of a root is one like
 * any other, and one that jumps is no constraint that is lost. Their columns are the functions. */
#ifndef SGA_TRAJ_DEFINED_H
#define SGA_TRAJ_DEFINED_H

#include "reduction.h"
#include "system.h"
#include "trajectory.h"

struct defined {
    const struct sys_system *sys;  /* the whole; borrowed, like the next two */
    const struct sga_solution *sol;
    const struct traj_request *rq;
    struct sys_system system;      /* what is left */
    struct sga_solution solution;
    struct traj_request request;
    int *place;                    /* by variable of the whole: that of what is left, or -1 */
    int *variable;                 /* the other way */
    double moved;                  /* where the start was found on the whole's constraints: over which distance; otherwise -1 */
    double *initial, *on;          /* the request's lists for what is left; owned */
    unsigned char *given, *held;
    struct traj_rate *rate;
    struct traj_event *event;
    unsigned char *beside;         /* by column: a definition with a root */
    expr_id *output, *integral, *exact, *map, *valued;
};

/* Whether a motion is that of what is left: not where a rate is asked of a variable that is defined. */
bool defined_any(const struct sga_solution *sol, const struct traj_request *rq);
/* The system, solution and request for what is left; defined_clear is due in every case. */
void defined_init(struct defined *d, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq);
/* Given and held values of variables that are defined: the start of what is left, in d->request, is made to fit them as far as it can.
 * False with err where held ones cannot be met. */
bool defined_start(struct defined *d, struct sga_error *err);
void defined_clear(struct defined *d);
/* False with err: x, of the whole, has a value that no double holds (s = cosh(10^6 x)). */
bool defined_in_doubles(const struct defined *d, const double *x, struct sga_error *err);
/* x of what is left becomes x of the whole, malloced, and x is freed. */
double *defined_lift(const struct defined *d, double *x);
/* The distance over which given values moved, to x, of the whole, where that of what is left is `moved`. */
double defined_moved(const struct defined *d, const double *x, double moved);
/* A consistent start of what is left becomes that of the whole. */
bool defined_initial(const struct defined *d, struct traj_initial *r, struct sga_error *err);

#endif
