/* Inside the points folder: steps of least norm. */
#ifndef SGA_POINTS_LEASTNORM_H
#define SGA_POINTS_LEASTNORM_H

/* d of least Euclidean norm with J d = -r, J dense c x n by rows (overwritten), by
 * Householder QR of J^T with column pivoting; dependent rows (diagonal below 1e-13 of the
 * first) are left out. perm (c) and work (c + c * c) are the caller's. Returns the numerical
 * rank. Cost c^2 n. */
int points_least_norm(int c, int n, double *J, const double *r, double *d, int *perm, double *work);

/* The same in two parts: the factors, in J, perm and work; and, as often as asked, d for an r. Costs c^2 n and c n. */
int points_least_norm_factor(int c, int n, double *J, int *perm, double *work);
void points_least_norm_solve(int c, int n, const double *J, int rank, const int *perm, const double *work, const double *r, double *d);
/* From the same factors: d (n) becomes the k-th of the n - rank orthonormal vectors that J maps to 0 (k = -1: the last of those before them); y (c) the least squares
 * solution of J^T y = -v (0 for rows left out; v, n, is overwritten). Costs c n each. */
void points_least_norm_kernel(int n, const double *J, int rank, const int *perm, const double *work, int k, double *d);
void points_least_norm_multipliers(int c, int n, const double *J, int rank, const int *perm, const double *work, double *v, double *y);

#endif
