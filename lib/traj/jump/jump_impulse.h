/* Inside the traj folder: velocities of masses after an impulse of constraints.
 *
 * With the positions held, M (v+ - v) is in the span of the gradients of the constraints by the velocities, which hold for v+; v are the velocities
 * as they are set. Velocities that are set stay: an impulse along their coordinates holds them there. For constraints that are linear in the velocities v+ is the nearest v that
 * they allow in the metric M (Gauss' principle of impacts; Moreau 1988, with no restitution); others are met by Newton steps. */
#ifndef SGA_TRAJ_JUMP_IMPULSE_H
#define SGA_TRAJ_JUMP_IMPULSE_H

#include "dd.h"
#include "jump_set.h"

struct sga_arena;

/* to->x: velocities after it; to->impulse (coordinates; allocated here, the caller's): M (v+ - v-) with v- of at->x. False with EVENT_SET: what is set contradicts the constraints;
 * or NOT_SUPPORTED: reactions are not known to be along these gradients. Cost: (coordinates + constraints) cubed, a few times. */
bool jump_impulse(struct jump *j, const struct jump_at *at, struct jump_to *to, const char *place, struct sga_error *err);
/* Velocities as they are set, by coordinate, and the multipliers of the conditions. */
struct impulse_found { num_dd *v0, *mu; };
/* The same in double-double, from what double has found: x (n of j) as it is set becomes what velocities are after the impulse; landed: of jump_impulse, its
 * start; found is in mem. False: no digits are won, or something has no value. */
bool jump_impulse_fine(const struct jump *j, num_dd t, num_dd *x, const struct jump_to *landed, struct impulse_found *found, struct sga_arena *mem);
/* y (directions x n): derivatives along the event as values are set (its time changes by tau) become those after that impulse, which left x; own: the mode with
 * its derivatives. False: as above. */
bool jump_impulse_slope(const struct jump *j, const struct traj_mode *own, num_dd t, const num_dd *x, const struct impulse_found *found, const struct jump_to *landed, const num_dd *tau, int q,
                        num_dd *y);
/* By constraint of the system: 1 if it is one on velocities, and so among those that impulses are along. */
void jump_impulse_conditions(const struct jump *j, unsigned char *is);

#endif
