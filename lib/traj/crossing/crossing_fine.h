/* Inside the traj folder: the step over a singular position (crossing.h) again, in double-double.
 *
 * Collocation at Radau's points, each moved onto the constraints, from the motion in double-double before the place, with twenty stages and more; steps with
 * different numbers of points are compared, and with the curve in double. Where they do not agree within the tolerances, shorter steps around the place are tried. */
#ifndef SGA_TRAJ_CROSSING_FINE_H
#define SGA_TRAJ_CROSSING_FINE_H

#include "crossing.h"
#include "precise.h"

struct crossing_fine {
    struct precise p;         /* of the crossing's flow */
    double at, from, to;      /* as struct crossing has them: the step may be a shorter one */
    num_dd *x0, *z;           /* n: the begin; stages x n: the points */
    double error;             /* of any point on it, by the sizes of variables: natural ones, or their values where these are larger */
};

/* c: found in double for the same request. False: not known so well; nothing is to be freed then. Cost: the motion in double-double up to the place once more, some hundreds of evaluations for
 * each length tried. */
bool crossing_fine_find(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, const struct crossing *c, struct crossing_fine *f);
/* x (n) at a time of the step, consistent but for the place itself; y: the columns of the request, or NULL. */
void crossing_fine_at(struct crossing_fine *f, num_dd t, num_dd *x, num_dd *y);
void crossing_fine_clear(struct crossing_fine *f);

#endif
