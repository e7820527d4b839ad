/* Solving square sparse systems A x = b by KLU (Davis and Palamadai Natarajan, ACM
 * TOMS 37 (2010) 36): block triangular form and AMD ordering once for a pattern, then
 * new values with the old pivots as long as these stay good, else with fresh pivots. */
#ifndef SGA_LIN_LU_H
#define SGA_LIN_LU_H

#include <stdbool.h>

struct lin_lu;
struct lin_sparse;

/* Copies and orders the pattern of a square matrix. Freed with lin_lu_free (NULL is
 * allowed). A matrix of size 0 is allowed and regular. */
struct lin_lu *lin_lu_new(const struct lin_sparse *pattern);
/* The same for a symmetric pattern: ordered as it is, without a matching of rows and columns, which loses the symmetry and with it a
 * power of the fill (chains of 300: 40 times the time). */
struct lin_lu *lin_lu_new_symmetric(const struct lin_sparse *pattern);
void lin_lu_free(struct lin_lu *lu);

/* Factors the matrix with these values (in the order of the pattern's entries). The
 * pivots of the last factorisation are used again; where that makes entries grow, or
 * meets a zero pivot, it factors anew with partial pivoting. False: a value is not
 * finite, or the matrix is exactly singular (structurally too); then it must not be
 * solved with. */
bool lin_lu_factor(struct lin_lu *lu, const double *val);

/* Reciprocal of the condition number of the last factored matrix. `crude`: smallest over
 * largest pivot, O(n), can be far too large. The other: Hager's 1-norm estimate with a
 * few solves, seldom off by more than a factor of 3. 0 where singular, 1 for size 0. */
double lin_lu_rcond_crude(const struct lin_lu *lu);
double lin_lu_rcond(struct lin_lu *lu);

/* What the ordering foretells of one factorisation: multiplications, 0 where it is not known. O(1). */
double lin_lu_foretold(const struct lin_lu *lu);

/* b becomes A^-1 b, or A^-T b. The last lin_lu_factor must have returned true. */
void lin_lu_solve(struct lin_lu *lu, double *b);
void lin_lu_solve_transposed(struct lin_lu *lu, double *b);

/* The sign of the determinant last factored; it tells two matrices of one pattern apart. O(n). */
int lin_lu_sign(const struct lin_lu *lu);

/* Factorisations so far: with fresh pivots, and with old ones; and the entries of L + U
 * at the last fresh one. For tests and for `work`. */
struct lin_lu_counts { int fresh, reused, fill; };
struct lin_lu_counts lin_lu_counts(const struct lin_lu *lu);

#endif
