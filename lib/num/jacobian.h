/* Sparse Jacobians of a tape's outputs with respect to some of its inputs.
 *
 * The pattern is found once, by structure. Values come from the partial derivatives
 * of each instruction, computed once per point, and then either by reverse
 * accumulation for each row over its own cone, or by forward accumulation for each
 * column over what depends on it, whichever is the shorter sum.
 * (Griewank & Walther, Evaluating Derivatives, ch. 3, 7.) */
#ifndef SGA_NUM_JACOBIAN_H
#define SGA_NUM_JACOBIAN_H

#include "tape.h"

struct num_jacobian {
    int rows, cols, nnz;
    int *start;        /* rows + 1: the entries of row r are start[r] .. start[r + 1] */
    int *col;          /* nnz: column of each entry, increasing within a row */
    struct num_jacobian_plan *plan;
};

/* Rows are the tape's roots; column j is input columns[j] (a position in the tape's
 * inputs, none twice). columns NULL: all inputs in order (ncolumns is ignored). The tape must outlive it. */
struct num_jacobian *num_jacobian_new(struct num_tape *t, const int *columns, int ncolumns);
/* Rows one after the other, columns increasing within each. Linear; asserted of new ones. */
bool num_jacobian_sane(const struct num_jacobian *j);
void num_jacobian_free(struct num_jacobian *j);

/* Values at the point `in`, in the order of `col`; out (may be NULL) takes the roots'
 * values of the same evaluation. False if a root or an entry is not finite; everything
 * is filled all the same. At a kink: abs has slope 0, min and max share it equally.
 * Cost: one evaluation, the partials, and the sum of the cones of the rows (or the
 * columns); a solve costs m^3 once and m^2 for each row or column that meets it. */
bool num_jacobian_eval(struct num_jacobian *j, const double *in, double *out, double *values);

/* As num_tape_compile, for the Jacobian and its tape. */
void num_jacobian_compile(struct num_jacobian *j, struct sga_exec *memory);
/* As num_tape_hold, for the Jacobian and its tape. */
void num_jacobian_hold(struct num_jacobian *j, const signed char *side);
bool num_jacobian_compiled(const struct num_jacobian *j);

#endif
