/* Inside the form folder only: vectors tangent to the zero set of functions. */
#ifndef SGA_FORM_TANGENT_H
#define SGA_FORM_TANGENT_H

#include "form.h"

/* A basis of the kernel of a dense rows x cols matrix of expressions (by rows, overwritten):
 * (cols - rank) vectors of cols entries one after the other, a new array; *count is how many.
 * Elimination crosswise, without division except by constants; a constant is the first
 * choice for a pivot. An entry that vanishes at a random point (of all symbols) is no pivot.
 * Cost: rows^2 cols operations. */
expr_id *form_kernel(struct expr_store *st, expr_id *matrix, int rows, int cols, int *count);

#endif
