/* Inside the run folder: a set of parameters put into an analysis in which they are symbols. */
#ifndef SGA_RUN_SWEEP_CASE_H
#define SGA_RUN_SWEEP_CASE_H

#include "oracle.h"
#include "reduction.h"
#include "system.h"
#include "trajectory.h"

struct job;
struct request;
struct request_sweep;

/* Copies in a store of their own, where the parameters are numbers. */
struct sweep_case {
    struct expr_store store;
    struct sys_system system;
    struct sga_solution solution;    /* of its lists only those are set that motions need */
    bool solved;                     /* the solution has values at these parameters */
    struct traj_request request;     /* its lists of expressions are copies */
    struct traj_turns turns;         /* the request's, where it has them; */
    struct traj_slopes slopes;       /* the same; */
    struct traj_set *set;            /* what its events set, */
    struct traj_mass mass;           /* and its masses */
    expr_id *node;                   /* all copied expressions */
    struct sga_solution own;         /* of the system at these parameters, where it was asked for */
    struct points_oracle oracle;
    bool has_own;
};

/* False with err (EXPR_UNDEFINED, a limit) where the system itself has no value there. sweep_case_clear
 * is due in every case. */
bool sweep_case_make(struct sweep_case *c, struct job *j, const struct sga_solution *solution, const struct traj_request *request,
                     const struct request_sweep *set, struct sga_error *err);
/* The same of any system over the request's store, with these values of its swept parameters. */
bool sweep_case_of(struct sweep_case *c, const struct request *of, const struct sys_system *s, const struct sga_solution *solution, const struct traj_request *request,
                   const expr_id *parameter, struct sga_error *err);
void sweep_case_clear(struct sweep_case *c);
/* Do the general analysis and its assumptions hold at these parameters, as seen from a point x of the final set at the start
 * time, good to some 9 digits? No pivot may vanish there, nor the rank of the constraints' differentials drop, nor a constraint
 * become a product: then the reduction at these values would take the same steps (zeros persist, by continuity).
 * False is not a proof that they do not. single: as below, or NULL. */
bool sweep_case_holds(struct sweep_case *c, const double *x, const unsigned char *single);
/* By constraint of the general solution: it has no parameters and is no product, so that it need not be looked at for each set. Malloced. */
unsigned char *sweep_case_single(struct expr_store *st, const struct sga_solution *s);
/* The reduction of the system at these parameters, near this start, into c->own. False with err. */
bool sweep_case_solve(struct sweep_case *c, struct job *j, const struct traj_request *start, struct sga_error *err);

#endif
