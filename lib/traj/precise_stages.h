/* Inside the traj folder: the stages of an implicit step in double-double.
 *
 * z_i = h sum_j a_ij X(t + c_j h, x + z_j): collocation at the Radau points. Residuals are
 * double-double; the Newton matrix A^-1 (x) 1 - h diag(J_1, ..., J_s), with a Jacobian of its own
 * for every stage, is double: each iteration gains the digits that the Jacobians are good to,
 * fourteen at the end, and rounding in the factors costs nothing in the result. */
#ifndef SGA_TRAJ_PRECISE_STAGES_H
#define SGA_TRAJ_PRECISE_STAGES_H

#include "collocation.h"
#include "lin_lu.h"
#include "precise_march.h"

struct precise_stages {
    int n, s;
    const struct num_radau *formula;
    num_dd *z, *f;             /* s x n: increments, and the field there */
    double *unit;              /* n: corrections are measured in these */
    double *residual, *rhs, *jac;
    double *dense; int *perm;  /* the matrix, or */
    struct lin_sparse *pattern; struct lin_lu *lu; int *place; double *entry;
    double work;               /* of all since it was set to 0, in multiplications in double-double */
};

enum precise_solved { STAGES_SOLVED, STAGES_DIVERGED, STAGES_REFUSED };

/* For steps of this march with about so many stages: fewer where the matrix would be too large. */
struct precise_stages *precise_stages_new(struct precise_march *m, int s);
void precise_stages_free(struct precise_stages *w);
/* From the guess in w->z. STAGES_REFUSED: the field has no value or no derivative on the way. */
enum precise_solved precise_stages_solve(struct precise_stages *w, struct precise_march *m, num_dd h);

#endif
