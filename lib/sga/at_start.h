/* Inside the sga folder: entries of the elimination where a motion is to start. Of entries that are no zeros in general a pivot
 * may be one that is 0 there (velocities are 0 at rest), and what is divided by it has no value then: others come first. */
#ifndef SGA_SGA_AT_START_H
#define SGA_SGA_AT_START_H

#include "ball.h"

struct ech_context;

struct at_start {
    struct num_ball ball;
    bool known;
};

/* What was given as it was, the rest as at the first point of the present set. */
void at_start_init(struct at_start *a, const struct ech_context *c);
void at_start_clear(struct at_start *a);
/* The value of e there; 0 where it has none, and where it is nothing but rounding. */
double at_start_value(struct at_start *a, expr_id e);
/* How many bits smaller e is there than at the first point; 100 where it is 0. */
double at_start_faintness(struct at_start *a, const struct ech_context *c, expr_id e);
/* Whether e is 0 there, beside what it is at the first point. */
bool at_start_vanishes(struct at_start *a, const struct ech_context *c, expr_id e);

#endif
