/* Nonlinear least squares within bounds: the least sum of squares of m functions of p unknowns.
 *
 * Levenberg's and Marquardt's method in units of the Jacobian's columns, with the damping of Nielsen (K. Madsen, H. B. Nielsen, O. Tingleff, Methods for
 * Non-Linear Least Squares Problems, 2004, section 3.2), by the singular values of the scaled Jacobian: directions of which they tell nothing are not
 * moved along. Unknowns at a bound that the sum presses them against stay there. It has converged where the
 * residual has no part left along what the unknowns can change, beside what is left of it (the relative offset of D. M. Bates and D. G. Watts,
 * Technometrics 23 (1981) 179), or beside what its values are good to. */
#ifndef SGA_FIT_LEAST_SQUARES_H
#define SGA_FIT_LEAST_SQUARES_H

#include <stdbool.h>

struct fit_problem {
    int m, p;
    void *ctx;
    const double *low, *high;      /* p; infinite: no bound */
    /* r (m) and J = dr/dx (m x p, by rows) at x. False: they have no value there. */
    bool (*value)(void *ctx, const double *x, double *r, double *J);
    bool (*goes_on)(void *ctx);    /* false: it is to end at once */
    double noise;                  /* a length of r that cannot be told from 0 */
    double unsure;                 /* entries of J are off by so much beside their column's length */
    int most;                      /* steps */
};

enum fit_status {
    FIT_CONVERGED,
    FIT_NO_VALUE,                  /* nor at the guess */
    FIT_TOO_MANY,                  /* steps */
    FIT_STALLED,                   /* no step makes the sum less, and it is not the least one as far as derivatives tell */
    FIT_STOPPED
};

struct fit_result {
    enum fit_status status;
    double *x, *r, *J;             /* p; m; m x p. Owned */
    double *size;                  /* p: of each unknown, the largest value on the way; 1 where it never left 0. Owned */
    unsigned char *bound;          /* p: it stays at a bound */
    double sum, offset;            /* of squares; the relative offset */
    int steps, evaluations;
};

/* From x (p), within the bounds. Where that does not converge, and unknowns change r at the guess by no more than the noise, once more with these held:
 * a column that is nothing but errors sends its unknown far away. Cost: each step m p^2. fit_result_clear is due in any case. */
void fit_least_squares(const struct fit_problem *q, const double *x, struct fit_result *result);
void fit_result_clear(struct fit_result *r);

/* What the data tell of the unknowns: singular values of J with columns of length 1. */
struct fit_spread {
    int p, rank;
    double *singular, *direction;  /* p, falling; p x p, by rows: unknowns over the length of their column, by singular value. Owned, as: */
    double *covariance;            /* p x p: of those that are told, without the variance of the data; 0 for others */
    unsigned char *told;           /* p: by the data */
};

/* bound: unknowns at a bound count as known; unsure: as above; noise: an unknown whose change by its size (as in a result) changes r by less is not told. */
struct fit_at { const double *size, *J; const unsigned char *bound; double unsure, noise; };
void fit_spread_of(const struct fit_at *at, int m, int p, struct fit_spread *s);
void fit_spread_clear(struct fit_spread *s);

/* A (m x p, by rows) = U diag(s) V^T, s falling: U overwrites A, V is p x p by rows (row i: the i-th right vector). One-sided Jacobi rotations (J. Demmel, K. Veselic,
 * SIAM J. Matrix Anal. Appl. 13 (1992) 1204): small singular values keep their digits. */
void fit_singular_values(double *A, int m, int p, double *s, double *V);

#endif
