/* Inside the sga folder: dense blocks, solved as one node. */
#ifndef SGA_SGA_BLOCK_H
#define SGA_SGA_BLOCK_H

#include "echelon.h"

/* Elimination by symbols costs m^3 nodes on a dense block, and texts that nobody reads.
 * Instead: choose r independent rows and columns by values (S = E[R, B] regular at the
 * first point, so regular in general), give each of them the pivot 1 with entries
 * S^-1 E[R, f] and right side S^-1 rhs as SOLVE nodes, and take the combinations from the
 * other rows. `index` lists the rows of the block. False: undecided.
 * Rows that became pivots are emptied; the others keep what is left of them. */
bool ech_block(struct echelon *e, const struct ech_context *c, struct ech_row *row, const int *index, int rows, int generation);

/* A function that vanishes where S is singular: the last component of the solution of
 *     [S b; c^T 0] y = (0, 1),  that is det S / det [S b; c^T 0],
 * with fixed b and c (Govaerts, Numerical methods for bifurcations of dynamical equilibria,
 * section 3.2). One node, however large S is; it has poles where the bordered matrix is
 * singular, but its zeros are zeros of det S. */
expr_id ech_block_test(struct expr_store *st, const struct ech_dense *block, int *solve);

/* Whether the matrix of each block is still regular at the first of the present points. */
bool ech_blocks_stand(const struct echelon *e, struct points_oracle *oracle);

#endif
