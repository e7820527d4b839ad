/* Inside the points folder: many digits of a point by few steps. */
#ifndef SGA_POINTS_DOUBLING_H
#define SGA_POINTS_DOUBLING_H

#include "differentials.h"

/* Newton's steps on the variables solved[0 .. constraints), the others fixed, with a matrix of as many digits as the
 * point has, so that each step doubles them: from 120 bits (p must be that near) to prec, as far as it goes.
 * For many bits of few unknowns; costs c^3 products of that many bits a step. */
void points_double_digits(struct points_jacobian *j, struct points_point *p, const int *solved, slong prec);

#endif
