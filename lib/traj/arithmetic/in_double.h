/* Inside the traj folder: a motion in double arithmetic, from its consistent start to rows and events. */
#ifndef SGA_TRAJ_IN_DOUBLE_H
#define SGA_TRAJ_IN_DOUBLE_H

#include <stdbool.h>

struct flow;
struct sga_error;
struct traj_request;
struct traj_result;

/* From r->initial (n) with the flow's field ready (field_slope_init): samples, events, errors, drift and ending into r, whose other members
 * are as they were. False with err: nothing that r holds beyond r->initial is complete. */
bool in_double_run(struct flow *f, const struct traj_request *rq, struct traj_result *r, struct sga_error *err);

#endif
