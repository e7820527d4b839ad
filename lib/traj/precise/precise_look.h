/* Inside the traj folder: the last step attempted as a curve in double-double, and where on it the function of an event is 0. */
#ifndef SGA_TRAJ_PRECISE_LOOK_H
#define SGA_TRAJ_PRECISE_LOOK_H

#include "precise_march.h"

/* A step's sums are good to so many roundings. */
#define PRECISE_ROUNDINGS 256.0

struct precise_look {
    struct precise_march *m;
    int event;
    bool slope;                /* the derivative along the motion, not the function */
    num_dd *x;                 /* n + 1: work; the solution where it was asked for last */
};

/* The function, or its derivative, on the solution at t; and at a point of it. */
num_dd precise_look_at(const struct precise_look *q, num_dd t);
num_dd precise_look_value(const struct precise_look *q, num_dd t, const num_dd *x);
/* The change of sign between a and b, to rounding; the values there are not of one sign. By regula falsi with halving (Illinois), and bisection where that is slow. */
num_dd precise_look_root(const struct precise_look *q, num_dd a, num_dd ga, num_dd b, num_dd gb);
/* Both ends and their values of the first interval around t, from `from` to `most` to both sides, that it changes its sign in. */
bool precise_look_bracket(const struct precise_look *q, num_dd t, double from, double most, num_dd out[4]);
/* 0 at b from somewhere after a on: there. */
num_dd precise_look_first(const struct precise_look *q, num_dd a, num_dd b);
/* By how much the function changes at t with changes of x by the errors allowed, or (rounding) by some roundings of what it is in the step, in each variable. */
double precise_look_doubt(const struct precise_look *q, num_dd t, bool rounding);
/* Whether it jumps over 0 at t, in the bracket b; how far from there roundings of x can make it do so. */
bool precise_look_jumps(const struct precise_look *q, num_dd t, const num_dd b[4]);
double precise_look_wander(const struct precise_look *q, num_dd t);

#endif
