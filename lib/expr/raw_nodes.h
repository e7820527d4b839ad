/* Inside the expression folder only: nodes made raw, and made again. */
#ifndef SGA_EXPR_RAW_NODES_H
#define SGA_EXPR_RAW_NODES_H

#include "expr.h"

/* The node (op, a, b), shared with an equal one. No simplification. */
expr_id expr_node_make(struct expr_store *st, enum expr_op op, int32_t a, int32_t b);
/* False, with the store's error set: a constant of so many bits is over the limit. */
bool expr_bits_ok(struct expr_store *st, double bits);
/* Node e of `from` made again in st: its children became to[child], symbols i with map[i] become that. cone.c */
expr_id expr_rebuild(struct expr_store *st, const struct expr_store *from, expr_id e, const expr_id *to, const expr_id *map);

#endif
