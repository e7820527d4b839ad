/* Inside the traj folder: the tangent space of the final set at a point, dense, with some variables fixed.
 *
 * All vectors are in units of `unit`, by all variables, 0 at those that are fixed. */
#ifndef SGA_TRAJ_TANGENT_H
#define SGA_TRAJ_TANGENT_H

#include "manifold.h"

struct tangent {
    struct manifold *m;
    const double *unit;          /* n, borrowed; may be exchanged between calls */
    int n, c;
    unsigned char *fixed;        /* n: variables that stay */
    int *column; int columns;    /* those that do not */
    double *barred; int bars;    /* directions (bars x n) that are left out too */
    double *r;                   /* c: constraints over the largest entries of their scaled gradients */
    double *basis; int dim;      /* dim x n, orthonormal: what the fixed, the barred and the constraints leave */
    int rank;
    double least;                /* of the factors' pivots; 1 without any */
    double *J, *work, *v, *y; int *perm;
    double *slope;               /* n + 1 */
    double effort;               /* operations so far, about; for searches that may be longer or shorter */
};

void tangent_init(struct tangent *t, struct manifold *m, const double *unit);
void tangent_clear(struct tangent *t);
/* After t->fixed was written. */
void tangent_fix(struct tangent *t);
/* A direction (n) more that is barred. After a tangent_at. */
void tangent_bar(struct tangent *t, const double *d);

/* At x: residuals, factors. Returns the largest residual; -1 where there is no value. Cost c^2 n. */
double tangent_at(struct tangent *t, double time, const double *x);
/* basis and dim. Cost c n for each of them. */
void tangent_basis(struct tangent *t);
/* d (n) of least length with J d = -r, r = t->r. What of r it cannot reach: the largest entry of r + J d. */
double tangent_normal(struct tangent *t, double *d);
/* y (c) of the scaled constraints for which J^T y is about as small as t->least. */
void tangent_weakest(struct tangent *t, double *y);
/* Multipliers y (c, of the scaled constraints) by least squares: J^T y = -v. */
void tangent_multipliers(struct tangent *t, const double *v, double *y);
/* J^T y at another point, of the constraints scaled as at the last tangent_at, into g (n). False: no value there. */
bool tangent_gradient(struct tangent *t, double time, const double *x, const double *y, const double *big, double *g);

/* Newton's method of least steps onto the set, each at most `longest` in every variable (INFINITY: full). x stays where it
 * fails. *easy: the first step was nearly all, so that no other point can be meant; NULL. */
bool tangent_settle(struct tangent *t, double time, double *x, double longest, int steps, bool *easy);

#endif
