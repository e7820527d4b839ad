/* Inside the traj folder: natural sizes of the variables, where they lie far from 1 (a charge of 1e-15 C, a pendulum of 1e-9 m).
 * Absolute tolerances that the request leaves open, and the nearest consistent start, are in units of them.
 *
 * Terms of an equation should be of one size, arguments of functions near 1, values that are given as they are: linear
 * equations for logarithms (points/scaling.h), time among the unknowns. A guess: results are looked at afterwards. */
#ifndef SGA_TRAJ_SIZES_H
#define SGA_TRAJ_SIZES_H

#include "trajectory.h"

struct sizes {
    double *weight;            /* by variable: what a move of 1 means for the nearest start: a power of 10 where no value is given, 1 or a size far
                                * from it where one is */
    double *unit;              /* by variable: what atol is times; at most 1, but for large variables that begin at 0 */
    double *column;            /* by column of the samples: the same; unit where there are no outputs */
    double *row;               /* by variable: what the rows that define the field are solved in units of */
    double time;               /* the same of times of events */
    int n, columns;
    bool any;                  /* some unit is not 1 */
    bool uneven, uneven_rows;  /* some weight, and some of `row`, is not 1 */
};

/* All 1 for more than SCALING_MOST variables. Units are 1 where the request gives atol. */
void sizes_init(struct sizes *s, const struct sys_system *sys, const struct traj_request *rq);
void sizes_clear(struct sizes *s);
/* Units that are far smaller than what their variables and columns became (size: by variable, grown: by column; may be one) grow
 * to it. Whether any did. */
bool sizes_grow(struct sizes *s, const double *variable, const double *column);
/* Units above 1, of large variables that begin at 0, shrink to what these became, at the least to 1, where that is far smaller: a term
 * may have told of a size at which it counts, and where the motion never is. Whether any did. */
bool sizes_shrink(struct sizes *s, const double *variable, const double *column);
/* Weights that are far smaller than where the motion starts (x, by variable) grow to it; where it starts at large values, so does `row`. */
void sizes_met(struct sizes *s, const double *x);
/* The unit of a value that moves from `value` towards consistency (weights alone, or its own size where that is large). */
double sizes_move(const struct sizes *s, int j, double value);

#endif
