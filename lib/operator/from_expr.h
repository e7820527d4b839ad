/* Rational functions of time from expressions. */
#ifndef SGA_OPERATOR_FROM_EXPR_H
#define SGA_OPERATOR_FROM_EXPR_H

#include <flint/fmpz_poly_q.h>

#include "expr.h"

/* out[k] (initialised) = e[k] as an element of Q(t), t the symbol `time`. Returns n, or the first k
 * whose expression is no such function (another symbol, sin, pi, a division by 0, a degree
 * above 1000); `why` then says what stands in the way. Cost: one operation per shared node. */
int op_from_exprs(fmpz_poly_q_struct *out, const struct expr_store *st, const expr_id *e, int n, int time,
                  char why[static 160]);

#endif
