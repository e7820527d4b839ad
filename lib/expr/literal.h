/* Inside the expression folder only: constants as the parser meets them. */
#ifndef SGA_EXPR_LITERAL_H
#define SGA_EXPR_LITERAL_H

#include "expr.h"

enum { LITERAL_MAX_EXPONENT = 5000 };

/* The exact value of a decimal literal (digits, at most one point, an exponent).
 * Fails with LIMIT_BITS past max_digits or +-LITERAL_MAX_EXPONENT. */
expr_id literal_number(struct expr_store *st, const char *text, size_t length, int max_digits,
                       struct sga_error *err);

/* Why a function of constants has no real value; NULL where nothing is wrong or
 * nothing can be said (arguments that are not exact constants). */
const char *literal_outside(const struct expr_store *st, enum expr_op op, expr_id a, expr_id b);

/* a ^ b with the limits and the domain of the grammar; EXPR_UNDEF and err on failure. */
expr_id literal_power(struct expr_store *st, expr_id a, expr_id b, long max_exponent, struct sga_error *err);

#endif
