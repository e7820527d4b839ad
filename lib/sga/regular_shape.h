/* Inside the sga folder: what the shape of an expression says of its zeros. */
#ifndef SGA_SGA_REGULAR_SHAPE_H
#define SGA_SGA_REGULAR_SHAPE_H

#include "state.h"

enum graph { NOT_GRAPH, GRAPH, PLAIN_GRAPH };

/* e = a x_j + b with a never zero and free of x_j: the zero set is a graph, so it is
 * regular and of one piece. Plain: a is free of all variables, so it hides no factor. */
enum graph regular_graph(struct state *s, expr_id e);
/* The same with a never zero, where no earlier constraint contains x_j: over each point
 * of the present set e has exactly one zero, so it brings no branches and no singular
 * points of its own. */
bool regular_fresh_graph(struct state *s, expr_id e);
/* What a product, power, quotient or odd function is made of, by its shape alone: the parts
 * that may vanish, each once. Returns how many, at most `most`. */
int regular_shape_factors(struct state *s, expr_id e, expr_id *part, int most);
/* Whether `part` is e up to its sign, a denominator, and factors that are nowhere 0: they vanish at the same places, to the same order. */
bool regular_same_zeros(struct state *s, expr_id e, expr_id part);
/* Whether the symbol occurs in e. */
bool regular_depends(struct state *s, expr_id e, int symbol);
/* Whether e divides by something that may vanish. */
bool regular_has_poles(struct state *s, expr_id e);

#endif
