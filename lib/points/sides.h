/* Inside the points folder: zeros that hold on one side only.
 *
 * abs(x) - x is 0 where x > 0, max(x, 1) - 1 where x < 1, sqrt(x^2) - x where x > 0: a
 * function made with these is one analytic function on each side of a surface, and what is
 * decided at points of one side says nothing about the other. The side is then part of
 * the answer. */
#ifndef SGA_POINTS_SIDES_H
#define SGA_POINTS_SIDES_H

#include "points.h"
#include "points_space.h"
#include "warnings.h"

struct points_beyond;
struct points_side;

/* Whether the operator is one analytic function on each side of a surface. */
bool points_switches(enum expr_op op);

/* What changes its sign where the node, whose operator switches, changes its branch; EXPR_UNDEF: it has one branch, and
 * no value beyond the surface (sqrt(x)). */
expr_id points_surface(struct expr_store *st, expr_id node);
/* 1, -1, or 0 where that is not decided. */
int points_sign_at(struct points_point *p, expr_id u);

/* e was found to be 0 at the point (list: its cone, values known). Adds to *side (count,
 * cap) each function on whose side that depends: with the other branch put in for it, e is
 * not 0 there. Not the switches of the constraints, which change the set too: beyond.h; NULL: there are none.
 * Costs one evaluation of the cone for each switching node. */
void points_sides_of(struct expr_store *st, struct points_point *p, expr_id e, const expr_id *list, int count,
                     const struct points_beyond *beyond, struct points_side **side, int *sides, size_t *cap);

/* The same where each switch alone leaves e at 0: pairs of them that do not, together (max(x, 0) max(y, 0)), of the first
 * POINTS_KEYS switches; room for POINTS_PAIRS. How many. */
enum { POINTS_KEYS = SGA_MOST_SIDE_PAIRS, POINTS_PAIRS = POINTS_KEYS * (POINTS_KEYS - 1) / 2 };
int points_pairs_of(const struct sga_budget *budget, struct expr_store *st, struct points_point *p, expr_id e, const expr_id *list, int count,
                    const struct points_beyond *beyond, const struct points_side *side, int sides, struct points_side (*pair)[2]);

/* Whether the point lies on all these sides (true too where one is undecided). */
bool points_on_sides(const struct expr_store *st, struct num_ball *b, const struct points_side *side, int sides);

/* Whether some constraint changes its branch (abs, sign, min, max) just at the point, so that its differential there is none. */
bool points_at_kink(const struct points_space *s, struct points_point *p);

#endif
