/* Matrices of expressions by compressed rows: most entries of a large one are 0. */
#ifndef SGA_EXPR_ROWS_H
#define SGA_EXPR_ROWS_H

#include "expr.h"

/* Room for so many entries in so many rows; start is 0. */
struct expr_rows expr_rows_new(int rows, int entries);
/* Of rows x cols by rows: what is not `zero`. */
struct expr_rows expr_rows_of(int rows, int cols, const expr_id *dense, expr_id zero);
/* The same without the entries `zero` (EXPR_NONE: all of them stay). */
struct expr_rows expr_rows_copy(const struct expr_rows *a, int rows, expr_id zero);
/* cols x rows. The columns of a row of a need not ascend: those of the result do. */
struct expr_rows expr_rows_transposed(const struct expr_rows *a, int rows, int cols);
/* Puts the columns of each row in ascending order. */
void expr_rows_sort(struct expr_rows *a, int rows, int cols);
bool expr_rows_same(const struct expr_rows *a, const struct expr_rows *b, int rows);
/* EXPR_UNDEF: not there. Cost: log2 of the row's length. */
expr_id expr_rows_at(const struct expr_rows *a, int row, int col);
void expr_rows_clear(struct expr_rows *a);

#endif
