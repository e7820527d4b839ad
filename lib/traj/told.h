/* Inside the traj folder: how far doubles tell a value. */
#ifndef SGA_TRAJ_TOLD_H
#define SGA_TRAJ_TOLD_H

#include "expr.h"

struct definitions;
struct sys_system;

/* What roundings may be of e, in the store of sys, at `in` (variables, then time): the units in the last place of all that is added up in it,
 * in whatever order, and in what defines its variables (or NULL). x - 1 + 1e-200 is not told from x - 1, nor s + 1e-200 where s = x - 1. Costs
 * a walk through e and through the definitions. */
double told_rounding(const struct sys_system *sys, const struct definitions *names, expr_id e, const double *in);

#endif
