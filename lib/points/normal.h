/* Inside the points folder: steps of least norm from a sparse Jacobian. */
#ifndef SGA_POINTS_NORMAL_H
#define SGA_POINTS_NORMAL_H

struct lin_kkt;

struct normal {
    int c, n;
    int *const *col; const int *cols;   /* borrowed: structural columns by row */
    double **value;                     /* by row, in that order: filled by the caller */
    struct lin_kkt *kkt;                /* for larger systems: ordered once for the pattern */
    double *packed;                     /* the values in one run */
    double *dense, *work;               /* for the QR, once it is used: c x n; see points_least_norm_in */
    int *perm;
};

void normal_init(struct normal *w, int c, int n, int *const *col, const int *cols);
void normal_clear(struct normal *w);
/* d of least norm with J d = -r. Small systems by QR of J^T; larger ones by the sparse
 * stationarity system, or by QR where that is numerically singular. Returns the
 * numerical rank. */
int normal_step(struct normal *w, const double *r, double *d);
/* d with J d = -r that moves as few variables as there are independent rows (not of least
 * norm); rows without entries and dependent ones are passed over. Sparse. Returns the
 * rank. For Jacobians some of whose columns are held. */
int normal_basic_step(struct normal *w, const double *r, double *d);

#endif
