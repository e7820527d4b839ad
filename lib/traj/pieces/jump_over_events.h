/* Inside the traj folder: events along a step over a singular position. */
#ifndef SGA_TRAJ_JUMP_OVER_EVENTS_H
#define SGA_TRAJ_JUMP_OVER_EVENTS_H

#include "jump_joined.h"

struct crossing;
struct crossing_fine;

/* What happens from the begin of the step to its end, behind what happened before (jump_cut there is due). f: the same step in double-double, or NULL. None of the events ends the
 * motion. Cost: some hundred points of the curve. */
void jump_over_events(struct jump_pass *p, struct jump_piece *q, const struct traj_request *rq, const struct crossing *c, struct crossing_fine *f);

#endif
