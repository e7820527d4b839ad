/* Inside the points folder: Gauss-Newton steps of least norm from a sparse Jacobian. */
#ifndef SGA_POINTS_NORMAL_H
#define SGA_POINTS_NORMAL_H

struct normal {
    int c, n;
    int *const *col; const int *cols;   /* borrowed: structural columns by row */
    double **value;                     /* by row, in that order: filled by the caller */
};

void normal_init(struct normal *w, int c, int n, int *const *col, const int *cols);
void normal_clear(struct normal *w);
/* d of least norm with J d = -r. Small systems by QR of J^T; larger ones by a sparse
 * factorization of J J^T where that is well conditioned, else by QR. Returns the
 * numerical rank. */
int normal_step(struct normal *w, const double *r, double *d);

#endif
