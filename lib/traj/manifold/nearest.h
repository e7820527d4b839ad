/* Inside the traj folder: the point of the final set that is nearest to a guess in some of its variables. */
#ifndef SGA_TRAJ_NEAREST_H
#define SGA_TRAJ_NEAREST_H

#include "tangent.h"

struct nearest {
    struct tangent *t;
    double time;
    const double *guess;         /* n */
    const double *weight;        /* n: by what the square of each distance counts; 0: the variable moves free of charge */
    const int *by_name;          /* n: the variables in the order of their names, for what symmetry leaves open */
};

/* x, on the set, moves on it to a place where sum weight_j ((x_j - guess_j) / unit_j)^2 is least among its neighbours: Newton's method on Lagrange's conditions (the second derivatives of the constraints by differences of the
 * first), each step brought back to the set, each lower than the one before. It ends where the gradient along the set
 * is rounding. t->fixed and t->barred stay as they are. False: it found no end, as
 * where variables free of charge go to infinity (a b = 1 from a = 0).
 * Cost: for each step two differentials for each dimension of the tangent space, and its cube. */
bool nearest_descend(const struct nearest *q, double *x);
/* Bars the directions along which the sum at x is fixed (by its second derivative); edge: of these, those in which no variable
 * that counts moves. */
void nearest_bar(const struct nearest *q, const double *x, bool edge);
/* Whether the sum bends down nowhere at x. */
bool nearest_least(const struct nearest *q, const double *x);
double nearest_sum(const struct nearest *q, const double *x);
/* Newton's step (n, in units) at x for a gradient (n) known better than in double; for iterative refinement. */
void nearest_refine(const struct nearest *q, const double *x, const double *gradient, double *step);

#endif
