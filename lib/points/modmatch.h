/* Inside the points folder: which variable each constraint is solved for, by shape. */
#ifndef SGA_POINTS_MODMATCH_H
#define SGA_POINTS_MODMATCH_H

#include "points.h"

/* The constraint with the fewest variables left is next: it is solved for one in which it is affine where there is one, never for one
 * under a function that is not algebraic, and the rest of them are free; one without any is solved for the last free variable that it
 * follows from. solved[i] as in points_point. False: some constraint is left without. Cost: as of
 * sorting what the constraints contain; ties of more steps in all than TIE_STEPS are left without. */
bool points_match_by_shape(const struct points_space *s, int *solved);

#endif
