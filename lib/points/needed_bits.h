/* Inside the points folder: how many digits make a numeric zero credible.
 *
 * A sum whose terms cancel to many digits may still not be 0: 1e-1500, exp(-10000) and
 * 1 - tanh(2000) are smaller than any fixed precision. What an expression can produce is
 * bounded by what it is made of: its constants, the magnitudes of its parts, the arguments
 * of its exponentials (the witness conjectures of Richardson, and of van der Hoeven, in
 * practical form). */
#ifndef SGA_POINTS_NEEDED_BITS_H
#define SGA_POINTS_NEEDED_BITS_H

#include "ball.h"

/* How far from 1 what a list of nodes is made of reaches, in bits: its constants, the sizes of its parts, the
 * arguments of its exponentials. Values are in b. */
double points_height(struct num_ball *b, const expr_id *list, int count);

/* Bits after the point to which a function must be seen to be 0 before that is believed.
 * `list` is its cone, with values in b; `height` that of the system whose set it is asked on: what the function
 * itself does not mention comes in through its points. Never less than 300. */
slong points_needed_bits(struct num_ball *b, const expr_id *list, int count, double height);

#endif
