/* Inside the sga folder: lists of the ways in which a constraint can vanish. */
#ifndef SGA_SGA_REGULAR_OPTIONS_H
#define SGA_SGA_REGULAR_OPTIONS_H

#include "state.h"

struct num_ball;
struct regular_option;

/* regular_form of e by itself, whatever the present set is; the options in no order. */
struct regular regular_alone(struct state *s, expr_id e);

/* Each option once; out (count) is copied. */
void regular_add(struct regular *r, const expr_id *out, int count);
/* The functions of both, each once. */
void regular_add_joined(struct regular *r, const struct regular_option *a, const struct regular_option *b);
/* The options of `from`, which is cleared. */
void regular_move(struct regular *to, struct regular *from);
/* How far a place is from the zeros of o's functions, about, in units of what moves of its coordinates mean. */
double regular_option_distance(struct state *s, const struct regular_option *o, const double *x, double t);
/* About how far the guess must move, first of all in values that were given, for o's functions and the given equations without
 * derivatives (but for `asked`, of which o is a part). Costs an evaluation for each variable. */
double guess_distance(struct state *s, const struct regular_option *o, expr_id asked);
/* How far the guess is from the present set, in values that were given, by steps from its first point: about that of the nearest place. Negative: the system
 * is too large to say so. */
double guess_distance_of_set(struct state *s);
/* Whether the guess meets a constraint not that all branches have, and in which nothing is but values that were given: then none of them keeps these. */
bool guess_is_off(struct state *s);
/* What a move of 1 in variable j means near x: as for the nearest consistent start. */
double regular_unit_near(const struct state *s, int j, const double *x);
/* A ball at a place, parameters at some general value; the caller clears it. */
void regular_ball(struct state *s, const double *x, double t, struct num_ball *b);
/* e's options, nearest to the guess first. The answer: how many are at the distance of the first, which the order of factors has put there. */
int regular_sort(struct state *s, expr_id e, struct regular *r);
/* Begin with the branch that the route takes; those before it come last. alike: as regular_sort says. */
void regular_follow_route(struct state *s, expr_id product, struct regular *r, int alike);

#endif
