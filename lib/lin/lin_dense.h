/* Dense solutions of least norm, with the rank and the singular values that they rest
 * on (GSL's SVD, Golub-Reinsch; one-sided Jacobi where that does not converge). For
 * small systems, and for those that the sparse way reports as singular.
 * Cost about 10 m n min(m, n). */
#ifndef SGA_LIN_DENSE_H
#define SGA_LIN_DENSE_H

#include <stdbool.h>

struct lin_dense {
    int rows, cols;
    const double *a;        /* by rows */
};

struct lin_least {
    int rank;               /* singular values above rtol times the largest */
    double residual;        /* |A x - b|, Euclidean */
    double largest, smallest_kept, largest_dropped;   /* singular values; 0: none */
};

/* x (cols) of least Euclidean norm among the minimisers of |A x - b|. rtol <= 0 stands
 * for max(rows, cols) times the rounding unit. out may be NULL. False (x is then 0): an
 * entry is not finite, or the SVD failed. */
bool lin_least_norm(const struct lin_dense *A, const double *b, double rtol, double *x,
                    struct lin_least *out);

/* The problem of lin_kkt.h with J of any rank: among the d (held ones 0) that minimise
 * |D (J d + r)|, D scaling the rows of J W^-1 to norm 1 (rows that are 0 stay), the one
 * of least |W (d - g)|. w, held, g may be NULL. out->residual is that of the scaled
 * conditions. Dense: keep rows * cols below about 1e6. */
struct lin_correction {
    const struct lin_sparse *J;
    const double *w;
    const bool *held;
    const double *r, *g;
};
bool lin_correction_dense(const struct lin_correction *p, double rtol, double *d,
                          struct lin_least *out);

#endif
