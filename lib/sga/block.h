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

/* Whether the matrix of each block is still regular at the first of the present points. */
bool ech_blocks_stand(const struct echelon *e, struct points_shadow *shadow);

#endif
