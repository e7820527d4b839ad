/* Solving (sigma I - J) x = b for a few shifts sigma, one real and some complex, and one
 * sparse J: the linear systems of an implicit Runge-Kutta method after its stages have
 * been decoupled. Dense elimination with row pivoting where J is small or full, KLU
 * (real and complex; one ordering for all shifts) otherwise. */
#ifndef SGA_LIN_SHIFT_H
#define SGA_LIN_SHIFT_H

#include <stdbool.h>

enum { LIN_SHIFTS = 4 };           /* shift 0 is the real one */

struct lin_shift;
struct lin_sparse;

/* For this square pattern (copied). Freed with lin_shift_free (NULL is allowed). */
struct lin_shift *lin_shift_new(const struct lin_sparse *pattern);
void lin_shift_free(struct lin_shift *s);

/* From the next factorisation on the matrices are sigma M - J: M's values (borrowed) in the order of the pattern's entries.
 * NULL, as at first: M = 1. */
void lin_shift_mass(struct lin_shift *s, const double *mass);

/* Factors shift k with J's values in the order of the pattern's entries; im must be 0
 * for k = 0. False: a value is not finite or the matrix is singular; that shift must not
 * be solved with. */
bool lin_shift_factor(struct lin_shift *s, int k, double re, double im, const double *val);

/* From the next factorisation on unknown j is taken in units of 2^e, about size[j] > 0, where the sizes lie far apart:
 * pivots are compared in these units, and nothing is rounded by it. To be called before a set of shifts is factored. O(n). */
void lin_shift_sizes(struct lin_shift *s, const double *size);

/* x in place of b: n numbers for k = 0, n pairs (re, im) for the others. */
void lin_shift_solve(struct lin_shift *s, int k, double *b);

/* The sign of the last real determinant factored; where M = 1, -1 says that an odd number of real
 * eigenvalues of J lies above sigma. O(n). */
int lin_shift_sign(const struct lin_shift *s);

/* About how many multiplications one factorisation of the real matrix takes; those of
 * complex matrices take four times as many. */
double lin_shift_cost(const struct lin_shift *s);
/* The same of one solution. */
double lin_shift_solve_cost(const struct lin_shift *s);

#endif
