/* Inside the traj folder: one motion of all its pieces, from event to event. */
#ifndef SGA_TRAJ_JUMP_PASS_H
#define SGA_TRAJ_JUMP_PASS_H

#include "jump_joined.h"

/* The whole motion once, at the tolerances times `tighter`, what is set and its time moved by `wrong` of their sizes (0: as they are). *p is cleared where it fails;
 * otherwise jump_pass_clear is due. Cost: for each event that sets that of a start and of a short trajectory. */
bool jump_pass_run(struct jump_pass *p, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double tighter, double wrong,
                   struct sga_error *err);
double jump_direction(const struct traj_request *rq);
bool jump_time_ended(const struct traj_result *r);
/* It ends at its last row, for want of time. */
void jump_end_at_rows(struct jump_pass *p, const struct traj_request *rq, const char *detail);

#endif
