/* Inside the linear folder: the motion while inputs do not move. */
#ifndef SGA_LINEAR_LINEAR_HELD_H
#define SGA_LINEAR_LINEAR_HELD_H

#include "linearize.h"

/* X + f Y by variable, in mem: the field among those of the final set (Y: the gauge fields) that leaves the inputs which are variables as
 * they are, Y_u f = -X_u. Inputs are the freedom (linear_coordinates.h). Pivots do not vanish at the place. Cost: the cube of the inputs in
 * expressions, nothing where X_u is 0 as it stands. NULL: no pivot is known not to vanish there. */
const expr_id *linear_held_field(struct sga_arena *mem, const struct linear_request *rq, struct linear_place *place);

/* How states move with the derivatives of inputs, a column for each input (0 for tables): Y_z Y_u^-1 at the place; initialised here. False: no
 * value. */
bool linear_held_shift(const struct linear_request *rq, struct linear_place *place, const int *state, int states, struct linear_matrix *out);

#endif
