/* Small dense linear solves in double: LU with partial pivoting. Matrices by rows. */
#ifndef SGA_NUM_LU_H
#define SGA_NUM_LU_H

#include <stdbool.h>

/* Factor a (m x m, overwritten): row i of L U is row perm[i] of a. False, with a left
 * half done, if a pivot is 0 or not finite. m^3 / 3 multiplications. */
bool num_lu_factor(double *a, int *perm, int m);
/* x = A^-1 b; x and b must not overlap. */
void num_lu_solve(const double *lu, const int *perm, int m, const double *b, double *x);
/* x = A^-T b; b is overwritten. */
void num_lu_solve_transposed(const double *lu, const int *perm, int m, double *b, double *x);

#endif
