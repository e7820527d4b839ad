/* Inside the traj folder: the gauge choice as a part of the field.
 *
 * The velocities that satisfy the equations and are tangent to Pf are v = X + sum_k u_k G_k, with the gauge
 * fields G_k of the reduction (echelon form: G_k is 1 at its own free column, 0 at the others). Rates and
 * least norm add rows to these equations:
 *     v_j = rate_j,    sum_j H_kj v_j = 0 for each gauge field H_k that the rates leave.
 * The echelon form of the equations holds, so that the new rows have to be reduced in the unknowns u alone: the
 * system that they make is as large as the freedom, whatever the number of variables. What comes out is that solution
 * of least Euclidean norm, over all of v, which field_general finds from the rows themselves. */
#ifndef SGA_TRAJ_GAUGE_CHOICE_H
#define SGA_TRAJ_GAUGE_CHOICE_H

#include "trajectory.h"

struct gauge_choice {
    expr_id *field;              /* n: the field with the choice in it; NULL: there is none as expressions */
    expr_id *pivot; int pivots;  /* what its rates divide by; none is a number */
    int fixed;                   /* independent rates */
    const char *why;             /* why there is no field, static; NULL where nothing had to be chosen */
};

/* The nodes are added to the system's store, a limited number of them unless the arithmetic is balls, which have no
 * other way. Cost: the nonzero entries of the gauge fields times their number. */
void gauge_choice_make(struct gauge_choice *c, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq);
void gauge_choice_clear(struct gauge_choice *c);

#endif
