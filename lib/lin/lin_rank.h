/* The numerical rank of a dense matrix, without its singular vectors. */
#ifndef SGA_LIN_RANK_H
#define SGA_LIN_RANK_H

#include "lin_dense.h"

/* *rank: how many singular values are above *bound; where that is 0 on entry it becomes rtol times the largest, or times `least` where that
 * is more. Singular values within some p * DBL_EPSILON of the largest of the bound may be counted either way (p: the larger of rows and
 * columns). Cost 4 p q^2 operations (q: the smaller). False (*rank is then 0): an entry is not finite. */
bool lin_rank(const struct lin_dense *A, double rtol, double least, double *bound, int *rank);

#endif
