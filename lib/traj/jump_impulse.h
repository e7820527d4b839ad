/* Inside the traj folder: velocities of masses after an impulse of constraints.
 *
 * With the positions held, M (v+ - v) is in the span of the gradients of the constraints by the velocities, which hold for v+; v are the velocities
 * as they are set. Velocities that are set stay: an impulse along their coordinates holds them there. For constraints that are linear in the velocities v+ is the nearest v that
 * they allow in the metric M (Gauss' principle of impacts; Moreau 1988, with no restitution); others are met by Newton steps. */
#ifndef SGA_TRAJ_JUMP_IMPULSE_H
#define SGA_TRAJ_JUMP_IMPULSE_H

#include "dd.h"
#include "jump_set.h"

/* to->x: velocities after it; to->impulse (coordinates; allocated here, the caller's): M (v+ - v-) with v- of at->x. False with EVENT_SET: what is set contradicts the constraints;
 * or NOT_SUPPORTED: reactions are not known to be along these gradients. Cost: (coordinates + constraints) cubed, a few times. */
bool jump_impulse(struct jump *j, const struct jump_at *at, struct jump_to *to, const char *place, struct sga_error *err);
/* The same in double-double, from what double has found: x (n of j) as it is set becomes what velocities are after the impulse; landed: of jump_impulse, its
 * start. False: no digits are won, or something has no value. */
bool jump_impulse_fine(const struct jump *j, num_dd t, num_dd *x, const struct jump_to *landed);
/* By constraint of the system: 1 if it is one on velocities, and so among those that impulses are along. */
void jump_impulse_conditions(const struct jump *j, unsigned char *is);

#endif
