/* The linearization about any point: matrices as expressions in the variables.
 *
 * As linearize.h says, but by algebra: the constraints' differentials are eliminated on the final set, where the zero oracle decides (dirac/weak.h), so that
 * Phi, and with it A, B, C, D, are functions on Pf. What was divided by is told. Parameters may be symbols. */
#ifndef SGA_RUN_LINEAR_SYMBOLIC_H
#define SGA_RUN_LINEAR_SYMBOLIC_H

#include <stdbool.h>

struct ask_work;

/* Writes the one object. False with err: INPUTS, IMPROPER, UNDECIDED, a limit. Cost: Gauss-Jordan steps in normal forms. */
bool linear_symbolic(struct ask_work *s);

#endif
