/* Inside the traj folder: the motion's equations as they stand, for large systems whose reduced field is dense.
 *
 * Where the rows with derivatives and the constraints are as many as the variables, they are the motion together:
 *     A x' = alpha,  xi = 0,
 * and the velocities solve one sparse system, [A; d xi] v = [alpha; -d_t xi]. Implicit steps are made on these equations themselves
 * (ode_implicit), so that the dense derivative of what was eliminated is never formed. */
#ifndef SGA_TRAJ_WHOLE_H
#define SGA_TRAJ_WHOLE_H

#include <stdbool.h>

struct field;
struct whole;

/* From so many variables on, and where a block of so many velocities was solved as a whole in the reduction. */
enum { WHOLE_VARIABLES = 60, WHOLE_BLOCK = 16 };

/* At the start (t, x). NULL: the equations are not of this shape, or nearly singular there. Cost: a tape, two orderings, a sparse factorisation. */
struct whole *whole_new(struct field *f, double t, const double *x);
void whole_free(struct whole *w);
/* v of the entries (those of field_rows.c: A's by rows, then d xi) and right sides (their negatives). False: singular. */
bool whole_velocities(struct whole *w, const double *entry, const double *right, double *v);
/* x to the constraints, with what A differentiates held. False: it does not get there in a few steps, and x is as it was. *raw: the largest |xi_i|. */
bool whole_project(struct whole *w, double t, double *x, const double *scale, double *moved, double *raw);
/* For the integrator, whose callbacks are those of `by`: they know the problem's ctx, and come to the two below. It is w's. */
const struct ode_implicit *whole_equations(struct whole *w, const struct ode_implicit *by);
bool whole_residual(struct whole *w, double t, const double *x, const double *v, double *r);
bool whole_matrices(struct whole *w, double t, const double *x, const double *v, double *mass, double *slope);

#endif
