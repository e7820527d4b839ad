/* Inside the traj folder: what in a field is a pulse or a step where its argument is near 0, and nothing far from it: the
 * arguments of exp, sinh, cosh, tanh, and n log|u| of high powers u^n, of a variable. See ode/band.c. */
#ifndef SGA_TRAJ_BANDS_H
#define SGA_TRAJ_BANDS_H

#include "expr.h"

/* Those in the cones of the roots into *argument (malloced); may add to the store. Returns how many. */
int bands_find(struct expr_store *st, const expr_id *root, int roots, expr_id **argument);

#endif
