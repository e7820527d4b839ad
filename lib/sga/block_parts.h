/* Inside block.c and block_rewrite.c: a dense block at work. */
#ifndef SGA_SGA_BLOCK_PARTS_H
#define SGA_SGA_BLOCK_PARTS_H

#include "block.h"

struct block {
    int m, n;             /* rows, columns that occur */
    int *col;             /* their numbers */
    struct expr_rows at;  /* m x n */
    int rank;
    int *rows, *cols;     /* the chosen ones (block numbering) */
    unsigned char *row_used, *col_used;
};

/* The rows of the block as its pivots leave them: those that were chosen become pivot rows, the others keep what is left of them. False: undecided. */
bool block_rewrite(struct block *b, struct echelon *e, const struct ech_context *c, struct ech_row *row, const int *index, int generation);

#endif
