/* Inside the points folder: steps from a start onto the constraints. */
#ifndef SGA_POINTS_NEWTON_H
#define SGA_POINTS_NEWTON_H

#include "parts.h"

struct points_point;
struct points_search;

/* Up to so many constraints all steps are short and thorough; from so many on they are made in doubles first; from so many on searches are cheap otherwise too. */
enum { POINTS_FEW = 40, POINTS_QUICK = 100, POINTS_MANY = 500 };

/* From p->x, which moves: 1 converged, 0 not, -1 where it creeps to a place at which the differentials are dependent. basic: by steps that move only
 * variables that no satisfied constraint contains, a few of them. */
int points_newton(struct points_search *w, struct points_point *p, struct points_parts *parts, bool basic);

#endif
