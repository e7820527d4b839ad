/* A sparse matrix in compressed rows: the pattern is fixed once, values are refilled.
 *
 * The entries of row i are ptr[i] .. ptr[i+1]-1, in the order in which the maker gave
 * them (columns need not ascend). No position occurs twice in a row. */
#ifndef SGA_LIN_SPARSE_H
#define SGA_LIN_SPARSE_H

struct lin_sparse {
    int rows, cols;
    int *ptr;       /* rows + 1 */
    int *col;       /* ptr[rows] */
    double *val;    /* ptr[rows]; 0 at first */
};

/* Copies the pattern. Asserts that columns are in range and that none occurs twice in a
 * row. Freed with lin_sparse_free (NULL is allowed). O(rows + cols + entries). */
struct lin_sparse *lin_sparse_new(int rows, int cols, const int *ptr, const int *col);
void lin_sparse_free(struct lin_sparse *a);

/* From `count` positions in any order, where one may occur more than once: place[k]
 * (count ints, caller's; may be NULL) tells which val belongs to position k, so that a
 * refill is: clear val, then val[place[k]] += v[k]. */
struct lin_sparse *lin_sparse_from_entries(int rows, int cols, int count,
                                           const int *row, const int *column, int *place);

/* y = A x (y: rows) and y = A^T x (y: cols). */
void lin_sparse_times(const struct lin_sparse *a, const double *x, double *y);
void lin_sparse_transpose_times(const struct lin_sparse *a, const double *x, double *y);

/* 1 where all of the n values are finite. */
int lin_all_finite(int n, const double *v);

#endif
