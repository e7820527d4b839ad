/* Inside the traj folder: in double-double, what derivatives of a motion do where it turns a switch (variation.h). */
#ifndef SGA_TRAJ_PRECISE_TURN_H
#define SGA_TRAJ_PRECISE_TURN_H

#include "dd.h"

struct precise;
struct precise_march;
struct precise_turn;
struct expansion;

/* NULL where nothing jumps, or with err. */
struct precise_turn *precise_turn_new(const struct precise *p, struct sga_error *err);
void precise_turn_free(struct precise_turn *w);
/* At m->here, with the sides before: where it is, the field, and by how much the time of the turn moves. False: they have no values. */
bool precise_turn_from(struct precise_march *m);
/* With the sides beyond, and those that turn with these (precise_carry; near as there): m->here becomes the point there. In double first, which judges whether there are such derivatives, then to all digits. False: m->why. */
bool precise_turn_to(struct precise_march *m, const struct expansion *near);

#endif
