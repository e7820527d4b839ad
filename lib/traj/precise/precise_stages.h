/* Inside the traj folder: the stages of an implicit step in double-double.
 *
 * z_i = h sum_j a_ij X(t + c_j h, x + z_j): collocation at the Radau points. Newton's method first
 * in double, with a Jacobian of its own for every stage, then with residuals in double-double and
 * the matrix of the end: each of these iterations gains nearly the digits of a double, and rounding
 * in the factors costs nothing in the result. */
#ifndef SGA_TRAJ_PRECISE_STAGES_H
#define SGA_TRAJ_PRECISE_STAGES_H

#include "dd.h"

struct precise_march;

/* precise_matrix.c. A^-1 (x) 1 - diag(K_1, ..., K_s), the K_i (n x n) of one sparse pattern; dense or KLU. */
struct lin_sparse;
struct num_radau;
struct stage_matrix;
struct stage_matrix *stage_matrix_new(const struct num_radau *formula, const struct lin_sparse *pattern);
void stage_matrix_free(struct stage_matrix *a);
/* value: s times the pattern's entries. False: singular or not finite. */
bool stage_matrix_factor(struct stage_matrix *a, const double *value);
/* r (s x n) becomes the solution of M d = (A^-1 (x) 1) r. */
void stage_matrix_solve(struct stage_matrix *a, double *r);
/* About what one factorisation, one solution takes, in multiplications in double. */
double stage_matrix_cost(const struct stage_matrix *a);
double stage_matrix_solve_cost(const struct stage_matrix *a);
/* The most stages that such a matrix is factored for; few, down to none, where Jacobians are large and full. */
int stage_matrix_most(const struct lin_sparse *pattern);

struct precise_stages {
    int n, s;
    const struct num_radau *formula;
    struct { double *a, *lo, *head, *tail; } split;   /* s x s: A, and the halves of its doubles */
    num_dd *z, *f;             /* s x n: increments, and the field there */
    double *unit;              /* n: corrections are measured in these */
    double *noise;             /* n: what rounding in the field leaves of the stages, where it is more than is allowed; else 0 */
    double *residual, *rough, *jac, *in;
    struct stage_matrix *matrix;
    bool factored;
    double work;               /* of all since it was set to 0, in multiplications in double-double */
};

enum precise_solved { STAGES_SOLVED, STAGES_DIVERGED, STAGES_REFUSED };

/* For steps of this march with so many stages, for which the matrix is not too large. */
struct precise_stages *precise_stages_new(struct precise_march *m, int s);
void precise_stages_free(struct precise_stages *w);
/* From the guess in w->z. STAGES_REFUSED: the field has no value or no derivative on the way. */
enum precise_solved precise_stages_solve(struct precise_stages *w, struct precise_march *m, num_dd h);

#endif
