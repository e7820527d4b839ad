/* Corrections of least weighted norm under linear conditions, sparse.
 *
 * For J (c x n), weights w_j > 0 and a given g (n):
 *     d minimises  sum_j w_j^2 (d_j - g_j)^2   subject to  J d = -r,  d_j = 0 where held.
 * With g = 0 this is the Gauss-Newton correction onto {xi = 0} (r = xi, J = d xi); with
 * g = x_given - x it is a step of the search for the nearest point to x_given.
 * A w_j is one over what counts as a unit of movement of variable j.
 *
 * Method: the stationarity system, scaled by y = W d and by D to rows of norm 1,
 *     [ alpha I        (D J W^-1)^T ] [ y  ]   [ alpha W g ]
 *     [ D J W^-1        0           ] [ mu ] = [ -D r      ]
 * factored by lin_lu. alpha = 1 unless J is so ill-conditioned that another value keeps
 * the system's condition near that of J instead of its square (Bjorck, Numerical Methods
 * for Least Squares Problems, 2.7.2). Cost: one ordering for a pattern, then a
 * refactorisation for each set of values. */
#ifndef SGA_LIN_KKT_H
#define SGA_LIN_KKT_H

#include <stdbool.h>

struct lin_kkt;
struct lin_sparse;

/* For this pattern of J (copied). Freed with lin_kkt_free (NULL is allowed). c = 0 and
 * n = 0 are allowed. */
struct lin_kkt *lin_kkt_new(const struct lin_sparse *J);
void lin_kkt_free(struct lin_kkt *k);
/* The rows hang together so that factors fill, as far as the ordering can tell: a step that moves as many variables as there are rows
 * may be found where one of least norm costs thousands of times more. O(1). */
bool lin_kkt_fills(const struct lin_kkt *k);

/* Takes J's values (in the order of the pattern's entries), w (n; NULL: all 1) and held
 * (n; NULL: none), and factors. False: a value is not finite, a weight is not positive,
 * or the rows of J W^-1, without the held columns, are numerically dependent
 * (rcond < 1e-13); then lin_kkt_solve must not be called and lin_correction_dense is the
 * way on. */
bool lin_kkt_factor(struct lin_kkt *k, const double *val, const double *w, const bool *held);

/* d (n) from r (c) and g (n; NULL: 0). May be called many times after one factor. */
void lin_kkt_solve(struct lin_kkt *k, const double *r, const double *g, double *d);

/* Smallest over largest singular value of the scaled D J W^-1 (held columns out), an
 * estimate by inverse iteration, usually within a factor of 2; 0 after a failed factor,
 * 1 for c = 0. Costs a few solves the first time it is asked after a factor. */
double lin_kkt_rcond(struct lin_kkt *k);

/* Factorisations and fill, see lin_lu_counts. */
struct lin_lu_counts lin_kkt_counts(const struct lin_kkt *k);

#endif
