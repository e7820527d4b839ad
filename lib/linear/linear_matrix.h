/* A matrix of numbers that are known exactly, or enclosed.
 *
 * One code over both: every operation works on rationals where all of its arguments are exact, and on balls otherwise; the balls of an
 * exact matrix enclose its rationals. A result is never more certain than what it came from. */
#ifndef SGA_LINEAR_LINEAR_MATRIX_H
#define SGA_LINEAR_LINEAR_MATRIX_H

#include <stdbool.h>
#include <arb_mat.h>
#include <flint/fmpq_mat.h>

enum { LINEAR_BITS = 192 };    /* of balls: 57 digits, so that what is lost on the way does not reach a double */

struct linear_matrix {
    bool exact;
    fmpq_mat_t q;              /* the numbers, where exact */
    arb_mat_t b;               /* their enclosures, always */
};

/* Zeros, exact. Cleared by linear_matrix_clear; all zero bytes are a matrix that bears it. */
void linear_matrix_init(struct linear_matrix *m, int rows, int cols);
void linear_matrix_clear(struct linear_matrix *m);
static inline int linear_rows(const struct linear_matrix *m) { return (int)arb_mat_nrows(m->b); }
static inline int linear_cols(const struct linear_matrix *m) { return (int)arb_mat_ncols(m->b); }

/* After entries of q were set in an exact matrix: their enclosures. */
void linear_matrix_enclose(struct linear_matrix *m);
/* These are initialised here. Columns or rows of a by index. */
void linear_matrix_columns(struct linear_matrix *out, const struct linear_matrix *a, const int *col, int cols);
void linear_matrix_rows(struct linear_matrix *out, const struct linear_matrix *a, const int *row, int rows);
/* a b; out is initialised here. Cost: the product of the sizes. */
void linear_matrix_product(struct linear_matrix *out, const struct linear_matrix *a, const struct linear_matrix *b);
/* a + b, or (minus) a - b, into a; sizes are equal. */
void linear_matrix_add(struct linear_matrix *a, const struct linear_matrix *b, bool minus);
/* out with a out = b, a square; initialised here. False: a is singular, or is not shown to be regular; out is zeros. */
bool linear_matrix_solve(struct linear_matrix *out, const struct linear_matrix *a, const struct linear_matrix *b);
/* How many columns are independent: *least is proved; true where it is the rank itself. Cost: the cube. */
bool linear_matrix_rank(const struct linear_matrix *a, int *least);
/* The double nearest to an entry, as far as its ball says. */
double linear_matrix_double(const struct linear_matrix *m, int row, int col);
/* A bound of |entry - that double| over all entries: 0 where exact numbers are doubles. */
double linear_matrix_error(const struct linear_matrix *m);

#endif
