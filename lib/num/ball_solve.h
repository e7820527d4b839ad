/* Inside the num folder: large sparse linear systems in balls. */
#ifndef SGA_NUM_BALL_SOLVE_H
#define SGA_NUM_BALL_SOLVE_H

#include "ball.h"

/* y (m): the solution of the system for every matrix and right side in the balls of values. False: no proof (ball_matrix.h says where none is tried), and y is not to be used.
 *
 * An approximation y~ by a sparse factorisation in doubles, corrected until what is left r of the right side is roundings; then with a lower bound s of
 * the least singular value of the matrix in units that make its rows and columns about 1, |y - y~| <= |r| / (s - |E|), E what the matrix in doubles is
 * wrong by. S. M. Rump, Verification methods, Acta Numerica 2010, 10.8. One radius for all unknowns in these units. A last row and column
 * that are filled are eliminated by blocks. Cost: least_singular.h. */
bool num_ball_solve_sparse(const struct num_ball *b, const struct expr_solve *s, arb_ptr y);

#endif
