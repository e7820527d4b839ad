/* Inside the traj folder: motions with events that set variables, as pieces between these events.
 *
 * At such an event its assignments are evaluated with the values before it, all at once (those of all events that happen at
 * this time), and the point is projected onto the constraints (jump_set.h); a new piece starts there. Errors: the whole motion is made twice, at the
 * tolerances and at a tenth of them, the looser one with what is set, and its time, moved by roundings; the difference, with what the piece has for its own, is the
 * estimate, so that errors of times and of pieces before are in it as the motion carries them. Tighter ones follow while it is too large. From where the two
 * have other events on nothing is known. A sample at the time of an event has the values before it.
 * Cost: for each event and each of the (two to MOST_PASSES) motions that of a start and of a short trajectory. */
#ifndef SGA_TRAJ_JUMPS_H
#define SGA_TRAJ_JUMPS_H

#include "trajectory.h"

/* As traj_run, in double. Ends with the reason "accumulation" where times of events have a limit. False also with EVENT_SET: what is set is off the constraints. */
bool jumps_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err);

#endif
