/* Inside the traj folder: derivatives of points that move as little as constraints let them.
 *
 * A point x that is nearest to y in a metric W, in its free variables, has
 *     W (x - y) + J^T lambda = 0,   xi(x, t, k) = 0,   J = xi_x,
 * and so along a direction (a prime; with time moving by tau)
 *     (W + H) x' + J^T lambda' = W y' - W' (x - y) - H_k - H_t tau,   J x' = -xi_k - xi_t tau,   H = sum of lambda_i xi_i,xx, and alike H_k, H_t. */
#ifndef SGA_TRAJ_LEAST_MOVE_H
#define SGA_TRAJ_LEAST_MOVE_H

#include "least_rows.h"

struct sga_arena;

/* What the conditions of a nearest point miss, by the sizes in them; a distance that is none, in units. */
#define LEAST_MISSED 1e-6
#define LEAST_NONE 1e-11

/* The constraints at a point: gradients, and what they change by. Lists are in the arena of least_move_at. */
struct least_move {
    struct least_rows *rows;
    double t;
    const double *x;
    int n, c, q;
    const double *tau;            /* by direction; NULL: time stays */
    double *J;                    /* c x n */
    double *by;                   /* c x q: xi_k + xi_t tau */
    double *miss;                 /* c: xi, about 0 */
    double *unit;                 /* n; the caller's to set, like the next two */
    unsigned char *use;           /* c; all 1 at first */
    signed char *free;            /* n: 1 moves */
    double *lambda;               /* c */
    double *H, *bent;             /* n x n; n x q: H_k + H_t tau */
};

bool least_move_at(struct least_move *l, struct least_rows *rows, double t, const double *x, const double *tau, struct sga_arena *mem);
/* lambda, with pull (n: W (x - y)) + J^T lambda = 0 where x moves. False: no constraints hold it there. floor: pulls, times units, that are none. */
bool least_multipliers(struct least_move *l, const double *pull, double floor, struct sga_arena *mem);
/* H and bent, of lambda. False: they have no value. Cost: the constraints' Jacobian times the variables. */
bool least_bend(struct least_move *l, struct sga_arena *mem);
/* s (n; what does not move is known): (W + H) s + J^T lambda' = push there, W n x n, and J s = -by (c; step: its distance in memory). False: they cannot hold. */
bool least_solve(const struct least_move *l, const double *W, const double *push, const double *by, int step, double *s, struct sga_arena *mem);

#endif
