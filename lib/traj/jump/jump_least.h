/* Inside the traj folder: derivatives of points that move as little as constraints let them (least_move.h, least_tiers.h), at an event. */
#ifndef SGA_TRAJ_JUMP_LEAST_H
#define SGA_TRAJ_JUMP_LEAST_H

#include "jump_slope.h"

/* An event, and its derivatives so far. */
struct jump_along {
    struct jump *j;               /* after it */
    const struct jump_at *at;
    const struct jump_to *to;
    const double *tau;            /* by direction */
};

/* y (directions x variables): derivatives of values as they are set (asked) become those of to->x, which an impulse made of them. False: it is not told. */
bool jump_least_impulse(const struct jump_along *a, const double *asked, double *y);
/* y: of to->x; become those of the start x, which was found in the way. False: it is not told. */
bool jump_least_start(const struct jump_along *a, const double *x, int way, double *y);

#endif
