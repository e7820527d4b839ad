/* Inside the traj folder: which way a motion goes on from a surface where the equations jump, in Filippov's sense.
 *
 * Each switch is a mode (trajectory.h): above its surface, below it, or along it. Along it the switch is a new variable and the surface's function a new
 * equation: of the values from -1 to 1 it takes the one by which the motion stays (Utkin's equivalent control), which gives a convex combination of the fields of both
 * sides (Filippov's): where it does not, because the switch enters the equations as no factor of anything linear, the motion ends, and says so.
 *
 * At a surface all values of the switches there are tried, each in its own reduction: a side is a way to go on where the first derivative of the surface's
 * function along its field that is not 0 leads into it; a slide, where its switch is between -1 and 1, or comes from there by the same rule, and nothing that has a derivative would have to jump. The motion goes on where one
 * way is left. Derivatives are exact expressions; each is told from 0 by what changes of the variables far below all tolerances do to it.
 * Cost: 3 to the number of surfaces at once reductions, each once, then that many starts. */
#ifndef SGA_TRAJ_SLIDE_H
#define SGA_TRAJ_SLIDE_H

#include "jump_set.h"

struct slide;

bool slide_any(const struct traj_request *rq);
struct slide *slide_new(void);
void slide_free(struct slide *s);

/* From the point of `at` (of mode `from`, whose jump is `now`) on: choice by surface, as it is and as it will be. False: *why (room for 256) says why no
 * way is known, or err what failed. */
bool slide_choose(struct slide *s, struct jump *now, const struct traj_mode *from, const struct jump_at *at, int *choice, char *why, struct sga_error *err);
/* At the start x of a piece in this mode: the sides of its events' zeros (ode_problem.event_side), for those of surfaces. */
bool slide_sides(struct slide *s, const struct traj_mode *m, double t, const double *x, signed char *side, struct sga_error *err);

#endif
