/* Inside the form folder only: vectors tangent to the zero set of functions. */
#ifndef SGA_FORM_TANGENT_H
#define SGA_FORM_TANGENT_H

#include "form.h"

/* Vectors of `cols` entries that span the kernel of a dense rows x cols matrix of expressions (by
 * rows, overwritten), one after the other in a new array; *count is how many.
 *
 * Constant pivots are eliminated first. What is left falls into blocks that share no column,
 * and a small block of m independent rows gives all its cofactor vectors, one for each choice of
 * m + 1 columns: more than a basis, but they span the kernel wherever the rows are independent, so
 * that no point is singular only because of an unlucky pivot. A block that is too large for
 * that is eliminated crosswise; the vectors are then a basis where the pivots do not vanish.
 *
 * vanishes(ctx, e) says what counts as zero (on the set that the vectors shall be tangent to);
 * NULL: what is zero at a random point of all symbols. Cost: rows^2 cols operations, and at
 * most FORM_COFACTORS vectors for each block. */
enum { FORM_COFACTORS = 200 };
expr_id *form_kernel(struct expr_store *st, expr_id *matrix, int rows, int cols, const struct form_zero *zero, int *count);

/* cofactors.c: the vectors of one block. row[i] points to `cols` entries of row i; col[] (increasing) are
 * the n columns of the block. Appends vectors of `cols` entries to *out (room for *count already there),
 * leaving out those that are the constant 0. False: too many of them, nothing appended. */
bool form_cofactors(struct expr_store *st, expr_id *const *row, int rows, const int *col, int n, int cols,
                    expr_id **out, int *count);

#endif
