/* Inside the points folder: starts at which functions have values. */
#ifndef SGA_POINTS_INTO_DOMAIN_H
#define SGA_POINTS_INTO_DOMAIN_H

#include "points.h"

/* Moves variables of the start p until the constraints of the space and what it lists as
 * `defined` have values there (sqrt(x), log(x), asin(x) at random x): those that a value is
 * missing for are drawn again, from smaller and larger boxes, or nearer to the guess. `box`
 * is how far from the guess the start was taken. Nothing is moved, and no random number
 * used, where all have values. False: some still have none; p is usable all the same. */
bool points_into_domain(const struct points_space *s, double box, uint64_t *random, struct points_point *p);

/* Whether what is listed as defined has values at the point: one where equations have none (sqrt(x) at x < 0) is a last resort. */
bool points_in_domain(const struct points_space *s, struct points_point *p);

#endif
