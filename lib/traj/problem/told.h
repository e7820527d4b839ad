/* Inside the traj folder: how far doubles tell a value. */
#ifndef SGA_TRAJ_TOLD_H
#define SGA_TRAJ_TOLD_H

#include "ball.h"

struct definitions;
struct sys_system;

/* One place, for many functions. */
struct told_place {
    const struct sys_system *sys;
    const struct definitions *names;
    struct num_ball at;
    struct expr_cone cone;
};

/* At `in` (variables, then time) of sys, both borrowed; names: of variables that count as what defines them, or NULL. told_end is due. */
void told_begin(struct told_place *t, const struct sys_system *sys, const struct definitions *names, const double *in);
void told_end(struct told_place *t);
/* What roundings may be of e, in the store of sys: the units in the last place of all that is added up in it, in whatever order, and in what
 * defines its variables. x - 1 + 1e-200 is not told from x - 1, nor s + 1e-200 where s = x - 1. Costs
 * a walk through e and through the definitions. */
double told_rounding(struct told_place *t, expr_id e);

#endif
