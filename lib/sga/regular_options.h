/* Inside the sga folder: lists of the ways in which a constraint can vanish. */
#ifndef SGA_SGA_REGULAR_OPTIONS_H
#define SGA_SGA_REGULAR_OPTIONS_H

#include "regular.h"

/* regular_form of e by itself, whatever the present set is. */
struct regular regular_alone(struct state *s, expr_id e);

/* Each option once; out (count) is copied. */
void regular_add(struct regular *r, const expr_id *out, int count);
/* The functions of both, each once. */
void regular_add_joined(struct regular *r, const struct regular_option *a, const struct regular_option *b);
/* The options of `from`, which is cleared. */
void regular_move(struct regular *to, struct regular *from);
/* How far a place is from the zeros of o's functions, about, in units of what moves of its coordinates mean. */
double regular_option_distance(struct state *s, const struct regular_option *o, const double *x, double t);
/* Nearest to the guess first. */
void regular_sort(struct state *s, struct regular *r);
/* Begin with the branch that the route takes; those before it come last. */
void regular_follow_route(struct state *s, expr_id product, struct regular *r);

#endif
