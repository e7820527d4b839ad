/* What the table of operators (expr.h) says of functions of one argument: where they have values, which, and the derivative.
 *
 * Symbolic derivatives, doubles, balls, power series and enclosures all take the derivative from here, each in its own arithmetic; ranges,
 * ends and refusals of numbers take the domains. */
#ifndef SGA_EXPR_OP_H
#define SGA_EXPR_OP_H

#include "expr.h"

/* Intervals of the table: symbol, has a low end, has a high one, low, high, whether the ends belong to it, in right angles (else 1), and
 * what is said of an argument that lies outside. */
#define EXPR_INTERVAL_TABLE(X) \
    X(ALL, false, false, 0, 0, false, false, "") \
    X(UNIT, true, true, -1, 1, true, false, "its argument lies outside -1 to 1") \
    X(INSIDE_UNIT, true, true, -1, 1, false, false, "its argument does not lie between -1 and 1") \
    X(FROM_0, true, false, 0, 0, true, false, "its argument is negative") \
    X(ABOVE_0, true, false, 0, 0, false, false, "its argument is not positive") \
    X(FROM_1, true, false, 1, 0, true, false, "its argument is less than 1") \
    X(QUADRANTS, true, true, -1, 1, true, true, "") \
    X(INSIDE_QUADRANTS, true, true, -1, 1, false, true, "") \
    X(HALF_TURN, true, true, 0, 2, true, true, "")

struct expr_interval {
    bool has_low, has_high;
    signed char low, high;
    bool closed;
    bool angles;              /* low and high count right angles */
    const char *outside;      /* of arguments */
};

enum expr_slope_of { EXPR_OF_NOTHING, EXPR_OF_ARGUMENT, EXPR_OF_VALUE, EXPR_OF_FUNCTION };
/* f'(x) = sign (shift + factor w^power)^(halves / 2), w the argument or f(x); OF_FUNCTION: sign function(x); OF_NOTHING: it is no function of one
 * argument, or its derivative is 0. */
struct expr_slope {
    signed char sign;
    enum expr_slope_of of;
    signed char shift, factor, power, halves;
    enum expr_op function;
};
/* The columns of the table as initializers in braces. */
#define EXPR_SLOPE(sign, w, shift, factor, power, halves) { sign, EXPR_OF_##w, shift, factor, power, halves, EXPR_UNDEF_OP }
#define EXPR_SLOPE_IS(sign, function) { sign, EXPR_OF_FUNCTION, 0, 0, 0, 0, EXPR_##function }
#define EXPR_NO_SLOPE { 0, EXPR_OF_NOTHING, 0, 0, 0, 0, EXPR_UNDEF_OP }

/* Where op has values; ALL for those with two arguments. */
const struct expr_interval *expr_op_domain(enum expr_op op);
/* An interval that all its values lie in. */
const struct expr_interval *expr_op_values(enum expr_op op);
const struct expr_slope *expr_op_slope(enum expr_op op);
/* An end of an interval as a constant. */
expr_id expr_interval_end(struct expr_store *st, const struct expr_interval *i, bool high);

#endif
