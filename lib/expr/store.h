/* Inside the expression folder only: a raw node without simplification. */
#ifndef SGA_EXPR_STORE_H
#define SGA_EXPR_STORE_H

#include "expr.h"

/* The node (op, a, b), shared with an equal one. No simplification. */
expr_id expr_node_make(struct expr_store *st, enum expr_op op, int32_t a, int32_t b);
/* False, with the store's error set: a constant of so many bits is over the limit. */
bool expr_bits_ok(struct expr_store *st, double bits);

#endif
