/* Inside the traj folder: what may jump where equations differentiate sums of variables.
 *
 * Rows sum of A_j(x) x_j' + alpha = 0 with bounded alpha hold, across a jump, what they differentiate: the jump is the limit of fast ramps,
 * along which dx lies in the kernel of A while what the constraints have lost falls to 0. Where each row differentiates one variable alone these
 * are the others (manifold_jump); x' + w' = ... holds the sum. Where ramps of different shapes lead to different ends (A depends on what jumps, and its
 * kernels fit no surfaces), or A jumps itself, the equations do not say how it jumps.
 *
 * Dense, for systems of up to LEAP_MOST variables; cost of a jump: some hundred singular value decompositions, some thousand where it is hard. */
#ifndef SGA_TRAJ_LEAP_H
#define SGA_TRAJ_LEAP_H

#include "switches.h"
#include "system.h"

struct flow;
struct sga_error;

enum { LEAP_MOST = 150 };

struct leap {
    struct num_tape *tape;        /* inputs: variables, time; roots: entries of the rows, one after the other */
    int *row, *col;               /* of each */
    int rows, entries;            /* rows that have entries */
    double undecided_t;           /* where ramps of different shapes led to different ends last, or NAN */
};

/* *out stays NULL where each row differentiates one variable alone, A jumps itself, or the system is too large. False: err says why. */
bool leap_init(struct leap **out, const struct sys_system *sys, const struct num_switches *w, struct sga_error *err);
void leap_clear(struct leap *l);                        /* and frees it; NULL is allowed */

/* x, whose constraints have jumped, moves to the set as said above. False, and x as it was: it cannot, or not in one way. */
bool leap_over(struct flow *f, double t, double *x);

/* A (rows x n) at (t, x), columns in the manifold's units, each row by its largest entry. False: it has no value. */
bool leap_rows(const struct flow *f, double t, const double *x, double *A);

#endif
