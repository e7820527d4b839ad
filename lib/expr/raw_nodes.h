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
/* Vectors by node that cones of a store have used: the next one takes them as they are, and a question about a few nodes does not clear
 * one for all. They end with the store and the last cone. marks.c */
struct expr_marks *expr_marks_new(void);
void expr_marks_leave(struct expr_marks *m);
/* To a cone that has none, and back. */
void expr_marks_lend(struct expr_marks *m, struct expr_cone *c);
void expr_marks_back(struct expr_cone *c);

#endif
