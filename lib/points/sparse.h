/* Inside the points folder: elimination of a rectangular sparse double matrix, for the
 * choice of which variables are solved for, and solves with the square part. */
#ifndef SGA_POINTS_SPARSE_H
#define SGA_POINTS_SPARSE_H

#include <stdbool.h>
#include <stddef.h>

struct points_row {
    int *col;
    double *val;
    int len, cap;
};

/* P J Q = L U by rows: each step takes the row of fewest entries whose largest entry is
 * acceptable, and in it the entry of the column that is in fewest rows among those not
 * below a tenth of the largest.
 *
 * Most of what fills are columns that become no pivots, of which solves use nothing (of the
 * flow in a cavity nine tenths; at 10^4 columns that is most of the time). From where an
 * elimination has cost many times what it began with, the rest is eliminated with rows cut to
 * some of their entries, so that its pivots' columns are a guess; then in these columns alone,
 * and rows that are left get others (sparse_complete.h). Where that leads to no pivots that are
 * regular, it goes on with whole rows. */
struct points_lu {
    int rows, cols, rank;
    struct points_row *row;       /* after elimination: U, in place; the last perhaps in pivots' columns alone */
    int *pivot_row, *pivot_col;   /* by step */
    double *pivot;
    struct { int row, step; double factor; } *op;   /* row -= factor * row of that step */
    size_t op_cap;
    int ops;
};

/* The matrix is consumed (its rows are the LU's from then on). Entries below `tiny` times
 * the row's first norm count as zero. Cost: the fill, or
 * that of the pivots' columns and some hundred operations for each entry. */
void points_lu_factor(struct points_lu *lu, struct points_row *row, int rows, int cols, double tiny);
void points_lu_clear(struct points_lu *lu);
/* Solve J x = b with x zero outside the pivot columns; b (rows) is overwritten, x (cols)
 * must be zero on entry. Rows without a pivot (rank < rows) are left as they come out. */
void points_lu_solve(const struct points_lu *lu, double *b, double *x);

#endif
