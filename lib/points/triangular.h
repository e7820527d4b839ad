/* Inside the points folder: points of constraint sets that are graphs over one another.
 *
 * Where constraint i is affine in a variable that no earlier one contains, the set is
 * solved one constraint after the other, one division each; the order follows from what contains what, or is that of
 * the constraints: no start can miss, and
 * numbers of any size are met (chains x_i' = x_(i+1) + x_i^2 reach 10^(2^n)). The balls are
 * enclosures, so the point is certified. */
#ifndef SGA_POINTS_TRIANGULAR_H
#define SGA_POINTS_TRIANGULAR_H

#include "points.h"

/* Sets the solved variables of p from the others, which keep their values (made exact), at
 * so many bits. False: the constraints do not have the shape, a slope may vanish, or (any_size not set) a value is larger than doubles. */
bool points_triangular(const struct points_space *space, struct points_point *p, slong prec, bool any_size);

#endif
