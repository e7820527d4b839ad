/* Inside the points folder: steps of least norm from a sparse Jacobian. */
#ifndef SGA_POINTS_NORMAL_H
#define SGA_POINTS_NORMAL_H

#include "arena.h"

#include <stdbool.h>

struct lin_kkt;
struct lin_normal;

struct normal {
    struct sga_arena mem;               /* of its vectors */
    int c, n;
    int *const *col; const int *cols;   /* borrowed: structural columns by row */
    double **value;                     /* by row, in that order: filled by the caller */
    double *packed;                     /* the same in one run */
    struct lin_kkt *kkt;                /* for larger systems, once it is used: ordered once for the pattern */
    struct lin_normal *quick;           /* once it is used; NULL too where the product would be full */
    bool quick_tried;
    double *dense, *work;               /* for the QR, once it is used: c x n; see points_least_norm */
    int *perm;
};

void normal_init(struct normal *w, int c, int n, int *const *col, const int *cols);
void normal_clear(struct normal *w);
/* Whether steps are sparse ones. */
bool normal_is_sparse(const struct normal *w);
/* d of least norm with J d = -r. Small systems by QR of J^T; larger ones by the sparse
 * stationarity system, or by QR where that is numerically singular. Returns the
 * numerical rank. */
int normal_step(struct normal *w, const double *r, double *d);
/* The same by the normal equations where these are certain enough: for corrections that are looked at
 * again, several times cheaper. */
int normal_quick_step(struct normal *w, const double *r, double *d);
/* d with J d = -r: of many rows that are independent of least norm, else one that moves as few variables as there are independent rows (not of least
 * norm); rows without entries and dependent ones are passed over. Sparse. Returns the
 * rank. For Jacobians some of whose columns are held. */
int normal_basic_step(struct normal *w, const double *r, double *d);

#endif
