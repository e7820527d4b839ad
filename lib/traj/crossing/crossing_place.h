/* Inside the traj folder: whether constraints cross themselves exactly, to rounding, near a point.
 *
 * Where the gradients of constraints xi(z) = 0, z being variables and time, are dependent (sum u_i grad xi_i = 0, |u| = 1) at a point of the set,
 * it crosses itself; where they are at a point next to the set, two of its branches pass each other, as near as one likes, and motions turn from the
 * one to the other's side. These are c + n + 2 equations for n + 1 + c unknowns: Gauss-Newton steps find where they are met best (H. B. Keller,
 * singular points by augmented systems), and what is left of xi there is the distance of the branches' pass, to its square in errors of the place.
 * Cost: six singular value decompositions of that size, and 2 n + 2 gradients each. */
#ifndef SGA_TRAJ_CROSSING_PLACE_H
#define SGA_TRAJ_CROSSING_PLACE_H

#include <stdbool.h>

struct flow;

/* z (n + 1: variables, then time) is near the place, and becomes it. The constraints of f->field are looked at, variables in `unit` (n), time in
 * `time`, in combinations whose gradients are orthonormal at `far` (n + 1), where they are independent. False: there is none, to rounding. */
bool crossing_place(struct flow *f, const double *unit, double time, const double *far, double *z);

#endif
