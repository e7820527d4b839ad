/* Inside the sga folder: for which values of the symbolic parameters a run of the reduction says nothing. */
#ifndef SGA_SGA_CONDITIONS_H
#define SGA_SGA_CONDITIONS_H

#include "state.h"

/* After a run, with a set or a contradiction: adds to *to what was taken for granted of the parameters. Each thing that was
 * divided by, each differential of a constraint and each contradiction is written on the set with as few variables as its
 * constraints allow; it vanishes there for special values of the parameters only if all its coefficients do. Cost: that of a
 * reduction by normal forms, for SGA_MOST_CONDITIONED constraints at the most: past it, and for functions that are too large, there is a warning. */
void conditions_note(struct state *s, struct sga_conditions *to);

/* One more: the functions do not all vanish. Dropped where one of them cannot, or where it is there already. */
void conditions_add(struct sga_conditions *to, struct expr_store *st, struct expr_facts *facts, const expr_id *function, int functions);

/* The same where functions that are no polynomials stop to be independent of each other and of numbers, as exp(k x) does at
 * k = 0 and sin(k t), sin(m t) do at k = m: for those values g is looked at again. of: which terms count, as in
 * poly_coefficients_of (0: all). */
void conditions_kernels(struct state *s, struct sga_conditions *to, expr_id g, unsigned of);

#endif
