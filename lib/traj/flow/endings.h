/* Endings of motions in words. Inside lib/traj only. */
#ifndef SGA_TRAJ_ENDINGS_H
#define SGA_TRAJ_ENDINGS_H

#include "ode.h"

struct flow;
struct traj_request;
struct traj_result;

/* r says that the motion ended at r->ended_t, as the integrator has it (reason). Where the field, its pivots, its denominators, the given equations or
 * a jump explain more, ended_reason and ended_detail say so, and ended_t is the zero of what is lost where that is told better. */
void traj_explain_end(struct flow *f, const struct traj_request *rq, enum ode_reason reason, struct traj_result *r);
/* It ended where other pivots may go on. */
bool ended_by_pivots(const struct traj_result *r);

#endif
