/* Inside and above the points folder: powers of two for variables whose natural sizes lie
 * far apart (1e150 y^2 - 1e-150 x = 0 has its points near y = 1e-150 sqrt(x)).
 *
 * Terms of a sum, and of a row A x' = alpha, should be of one size, arguments of elementary
 * functions near 1: linear equations for the logarithms of the variables' sizes, solved by
 * least squares (geometric scaling, Fulkerson & Wolfe 1962, for nonlinear terms). */
#ifndef SGA_POINTS_SCALING_H
#define SGA_POINTS_SCALING_H

#include "expr.h"

struct scaling;
struct scaling *scaling_new(const struct expr_store *st, const int *variable, int variables);
void scaling_free(struct scaling *w);
/* A sum begins: what is added until the next one is of one size. */
void scaling_sum(struct scaling *w);
/* The terms of e, times the velocity of a variable (by index; -1: none). */
void scaling_add(struct scaling *w, expr_id e, int velocity);
/* By variable, log2 of its size, bounded so that doubles can hold it; NULL where all are
 * near 1 or nothing is known. The caller frees it. */
int *scaling_solve(struct scaling *w);

#endif
