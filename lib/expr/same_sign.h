/* Functions whose signs are another's. */
#ifndef SGA_EXPR_SAME_SIGN_H
#define SGA_EXPR_SAME_SIGN_H

#include "expr.h"

/* A function with e's sign everywhere, without a jump and with a rate at its zero where that is seen: u for u^3, 3*sinh(u), u*abs(u); and where e has its values from the sign of one
 * u alone, negative on one side and positive on the other (sign(u), if(u > 0, 3, -1/7)), u or -u, unless u has branches (and may rest at 0). Otherwise e. Cost: e's cone. */
expr_id expr_same_sign(struct expr_store *st, expr_id e);

/* e without its outermost operation, where that leaves its sign everywhere (u^3, sinh(u), u*abs(u), 3*u), or, which turns *turns, changes it. e: it is none of these. */
expr_id expr_peeled(const struct expr_store *st, expr_id e, bool *turns);

/* The u whose sign alone e has its values from, and those, constants, where it is negative and positive; EXPR_UNDEF: there is none. Cost: e's cone. */
expr_id expr_by_one_sign(struct expr_store *st, expr_id e, expr_id *below, expr_id *above);
/* The product with `by` in the place of one of its factors (build.c); EXPR_UNDEF: it has no such factor, as far as it was looked for. */
expr_id expr_put_for_factor(struct expr_store *st, expr_id product, expr_id factor, expr_id by);

#endif
