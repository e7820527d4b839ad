/* Inside the points folder: starts for large sets, on which constraints are met one after the other. Newton's steps on all from a far start
 * go along a chain of rods link by link, or not at all; each constraint with its new variables is met in a few. */
#ifndef SGA_POINTS_ONE_BY_ONE_H
#define SGA_POINTS_ONE_BY_ONE_H

struct points_jacobian;
struct points_point;

/* Moves p: each constraint in turn is met by the variables that none before it contains, by steps of least norm; that with the fewest of
 * them is next. Constraints without new variables, and those that the steps do not lead to, are left to a search of all together.
 * Cost: linear, some evaluations of each constraint. */
void points_one_by_one(struct points_jacobian *j, struct points_point *p);

#endif
