/* Inside the traj folder: quotients that have names, at zeros of what they divide by.
 *
 * With s = y/x and y' = s the field has no pole: s' is 0 along x' = 1. With y/x in the place of s it has one, and what y is beyond x = 0 neither says. So variables that an
 * equation gives (definition.h) are put in where they stand, and their values looked at on what is left of the constraints: x/t stays bounded where x = t y is another
 * equation, y/x does not. */
#ifndef SGA_TRAJ_POLE_NAMED_H
#define SGA_TRAJ_POLE_NAMED_H

#include <stdbool.h>

struct field;
struct manifold;

struct pole_named;

/* NULL: no variable is given by a quotient. Cost: a walk through the equations, as definitions_find. */
struct pole_named *pole_named_new(const struct field *f);
void pole_named_free(struct pole_named *q);      /* NULL is allowed */
/* What is left of the constraints; how many values there are, and these at `in` (variables, time). */
struct manifold *pole_named_rest(struct pole_named *q);
int pole_named_count(const struct pole_named *q);
void pole_named_values(struct pole_named *q, const double *in, double *w);

#endif
