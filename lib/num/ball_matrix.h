/* A large sparse matrix of balls, in doubles: its values in units that make its rows and columns about 1, and what these are wrong by. */
#ifndef SGA_NUM_BALL_MATRIX_H
#define SGA_NUM_BALL_MATRIX_H

#include "ball.h"

struct lin_sparse;

/* So small a part of a matrix is filled where sparse ways are taken, and so many rows it has: below, the dense ways cost less, and their radii are narrower. */
enum { NUM_BALL_MATRIX_ROWS = 64, NUM_BALL_MATRIX_PART = 12 };

struct num_ball_matrix {
    int rows, cols, entries;
    arb_srcptr *entry;             /* by entry of B, borrowed of the ball's values */
    slong *row, *column;           /* log2 of what rows and columns are multiplied by */
    struct lin_sparse *B;
    double error;                  /* a bound of the Frobenius norm of what B is wrong by */
};

/* Of the first rows and columns of at, whose nodes' values are known. False: it is small or filled, has an empty row or column, an entry that is
 * not finite or has 0 in the middle, or sizes that no units bring into doubles. To be cleared in any case. Linear. */
bool num_ball_matrix_init(struct num_ball_matrix *w, const struct num_ball *b, int rows, int cols, const struct expr_rows *at);
void num_ball_matrix_clear(struct num_ball_matrix *w);

#endif
