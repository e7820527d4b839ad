/* Expressions as one would write them by hand, without multiplying anything out. */
#ifndef SGA_EXPR_COLLECT_H
#define SGA_EXPR_COLLECT_H

#include "expr.h"

/* Roots are replaced in place by equal expressions (wherever those have values) with like terms together, numbers
 * folded, equal factors as powers, and factors that all terms of a sum share in front of it. What is too large stays. Cost:
 * linear in the cone, with sums of 64 terms at the most. */
void expr_collect(struct expr_store *st, expr_id *root, int roots);
/* A number times e, the same way: of a sum, times each of its terms. EXPR_UNDEF where the store is over a limit. */
expr_id expr_collect_times(struct expr_store *st, const fmpq_t number, expr_id e);

#endif
