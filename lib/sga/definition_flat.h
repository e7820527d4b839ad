/* Definitions where the functions have no derivative: s = abs(x y - 1) where x y = 1, s = sqrt(x y) where x = 0. */
#ifndef SGA_SGA_DEFINITION_FLAT_H
#define SGA_SGA_DEFINITION_FLAT_H

#include "definition.h"

/* Whether e, with what is defined put in, has a derivative by each variable at the oracle's first point. */
bool definition_smooth(const struct definitions *d, const struct sys_system *system, struct points_oracle *oracle, expr_id e);

/* A function equal to f on the set of the oracle's points, in which switches and roots that stay at their ends there are put
 * as the values that they keep (abs(g) as 0 where g is 0, max(g, h) as g where g is h); f itself where that gives none with
 * derivatives. Only what vanishes by algebra counts. */
expr_id definition_flattened(const struct definitions *d, const struct sys_system *system, struct points_oracle *oracle, expr_id f);

#endif
