/* Inside the sga folder: searches of the present set for places where a function vanishes.
 * None of them is exhaustive; what they find is certified by points of the set. */
#ifndef SGA_SGA_PLACE_SEARCH_H
#define SGA_SGA_PLACE_SEARCH_H

#include "state.h"

/* A point of the present set where `extra` vanishes too, or (IRREGULAR) the place that was
 * approached. *p is to be cleared whatever the status. */
enum points_status place_with(struct state *s, expr_id extra, struct points_point *p);
/* New points of the oracle near a place; its present points are not used as starts. */
enum points_status place_sample_near(struct state *s, const double *x, double t);
/* Gradient components may vanish where e does not, far from where they were tried: look
 * for such a place on the present set. True: none was found. */
bool place_vanishes_far(struct state *s, expr_id e);
/* Whether e vanishes all over some other branch of the present set than the one that the
 * points lie on, such as x - sqrt(2) on x^2 = 2. The points may have moved afterwards. */
bool place_holds_elsewhere(struct state *s, expr_id e);
/* e may hold all over one side of a surface (abs(x y) = x y, sign(x) = 1): look for points
 * of the present set where it does, and go on there. */
bool place_holds_on_side(struct state *s, expr_id e);

#endif
