/* Factors of functions that are equal up to the names of their symbols, as those of the members of a chain or grid are: the first one is factored, and
 * the others have its factors with their own symbols. */
#ifndef SGA_POLY_ALIKE_H
#define SGA_POLY_ALIKE_H

#include "poly.h"

struct poly_alike;

/* Of one store, with the same limits in every question. */
struct poly_alike *poly_alike_new(struct expr_store *st);
void poly_alike_free(struct poly_alike *a);
/* As poly_numerator_factors. Cost: where one like e was asked for before, the nodes of e and of its factors. */
bool poly_alike_factors(struct poly_alike *a, expr_id e, const struct poly_limits *limits, struct poly_factors *out);

#endif
