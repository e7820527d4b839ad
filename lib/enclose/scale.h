/* Inside the enclose folder: guesses that a step is chosen by. Nothing rests on them. */
#ifndef SGA_ENCLOSE_SCALE_H
#define SGA_ENCLOSE_SCALE_H

#include "tail.h"

/* log2 of the step at which the last coefficients of a series are 2^-bits of its first ones, or below 2^-slack of the width, for all
 * variables; HUGE_VAL where none is left. */
double enc_scale_step(const struct enc_series *s, mag_srcptr width, double bits, double slack);
/* After enc_tail_find: by variable, log2 of the size that rounding errors have, without what cancels: of x_j, and R times that of
 * what X_j is added up from. scratch: a mag for each slot. */
void enc_scale_of(const struct enc_tail *t, mag_ptr scratch, double *log2_scale);

#endif
