/* Inside the traj folder: where the constraint set crosses itself (dead centres, change-over points of linkages) and the motion goes on along
 * its own analytic curve.
 *
 * Near such a place the constraints' gradients become dependent as the distance to it, and steps that come near lose the branch in
 * roundings. So one long step is made from well before the place to well beyond it: collocation at Gauss points (none is near the middle),
 * each moved onto the constraints, its derivatives from the field there, found by iteration from a polynomial through the motion before.
 * It is taken only where steps with different numbers of points agree within the tolerances, and with the motion itself before the place:
 * so the curve is analytic there as far as they tell; where it ends (an impasse: a root) they do not agree, and the motion ends as before.
 * Cost: the motion up to there once more, some dozens of evaluations and projections. */
#ifndef SGA_TRAJ_CROSSING_H
#define SGA_TRAJ_CROSSING_H

#include "trajectory.h"

struct flow;

struct crossing {
    struct flow *flow;        /* owned */
    int n, count;             /* variables; points of the polynomial */
    double at;                /* the singular place, */
    double from, to;          /* and the step's ends, the second in the motion's direction from the first */
    double *t, *x;            /* count; count x n: its points, in no order */
    double *end;              /* n: the point at `to`, consistent */
    double *unit;             /* n: sizes that the constraints and the way made give the variables there, whatever units they are in */
    double error;             /* of it, in units of the tolerances, as two steps differ */
};

/* rq is the request of a motion that ended at time `at` by a fall of the rank. False: it is not continued; nothing is to be freed then. In double, with
 * the gauge choice of the motion, where no knot of a table lies in the step. */
bool crossing_find(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double at, struct crossing *c);
/* x (n) at a time between from and to, consistent but for the place itself; y: the columns of rq there, or NULL. Errors are as those of `end`. */
void crossing_at(const struct crossing *c, double t, double *x, double *y);
void crossing_clear(struct crossing *c);

#endif
