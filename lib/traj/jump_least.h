/* Inside the traj folder: derivatives of points that move as little as constraints let them.
 *
 * A point x that is nearest to y in a metric W, in its free variables, has
 *     W (x - y) + J^T lambda = 0,   xi(x, t, k) = 0,   J = xi_x,
 * and so along an event (a prime: with its time moving by tau)
 *     (W + H) x' + J^T lambda' = W y' - W' (x - y) - H_k - H_t tau,   J x' = -xi_k - xi_t tau,   H = sum of lambda_i xi_i,xx, and alike H_k, H_t.
 * Of points that are found tier by tier those of each tier are held in the next ones. */
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
