/* Inside the form folder only: vectors tangent to the zero set of functions. */
#ifndef SGA_FORM_COFACTORS_H
#define SGA_FORM_COFACTORS_H

#include "form.h"

enum { FORM_COFACTORS = 200 };

/* cofactors.c: the vectors of one block. row[i] points to `cols` entries of row i; col[] (increasing) are
 * the n columns of the block. Appends vectors of `cols` entries to *out (room for *count already there),
 * leaving out those that are the constant 0. False: too many of them, nothing appended. */
bool form_cofactors(struct expr_store *st, expr_id *const *row, int rows, const int *col, int n, int cols,
                    expr_id **out, int *count);

#endif
