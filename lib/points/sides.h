/* Inside the points folder: zeros that hold on one side only.
 *
 * abs(x) - x is 0 where x > 0, max(x, 1) - 1 where x < 1, sqrt(x^2) - x where x > 0: a
 * function made with these is one analytic function on each side of a surface, and what is
 * decided at points of one side says nothing about the other. The side is then part of
 * the answer. */
#ifndef SGA_POINTS_SIDES_H
#define SGA_POINTS_SIDES_H

#include "points.h"

/* Whether the operator is one analytic function on each side of a surface. */
bool points_switches(enum expr_op op);

/* e was found to be 0 at the point (list: its cone, values known). Adds to *side (count,
 * cap) each function on whose side that depends: with the other branch put in for it, e is
 * not 0 there. Costs one evaluation of the cone for each switching node. */
void points_sides_of(struct expr_store *st, struct points_point *p, expr_id e, const expr_id *list, int count,
                     struct points_side **side, int *sides, size_t *cap);

/* Whether the point lies on all these sides (true too where one is undecided). */
bool points_on_sides(const struct expr_store *st, struct num_ball *b, const struct points_side *side, int sides);

#endif
