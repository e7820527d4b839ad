/* Inside the traj folder: what pieces in double-double hand on, in all their digits. */
#ifndef SGA_TRAJ_JUMP_EXACT_H
#define SGA_TRAJ_JUMP_EXACT_H

#include "jump_piece.h"

struct expr_store;
struct jump;
struct num_dd;

bool jump_is_exact(const struct traj_request *rq);
/* The first piece of q, of rq: what was given, exactly; the rest is found as in any start in double-double. */
void jump_exact_start(struct jump_piece *q, const struct traj_request *rq);
/* The next one, in j, a mode of switches: it begins at the time of the last event of the piece before, where the variables of the start that have a derivative are what they
 * were. */
void jump_exact_next(struct jump_piece *q, const struct jump *j, const struct traj_result *piece);
/* The next one begins at t, x (n); given: those that it is held to. */
void jump_exact_place(struct jump_piece *q, struct expr_store *st, double t, const unsigned char *given, const struct num_dd *x);
/* The rational that a text of digits rounds to in double-double; NULL: that of the double. */
expr_id jump_exact_constant(struct expr_store *st, const char *digits, double about);
/* The samples from `done` on. */
void jump_exact_times(struct jump_piece *q, const struct traj_request *rq, int done);
/* Of values at a place of both results' rows: by how much they differ; and of the time of an event of both. */
double jump_difference(const struct traj_result *a, const struct traj_result *b, size_t at);
double jump_time_difference(const struct traj_result *a, int i, const struct traj_result *b, int k);
/* A rounding, of size 1, of the arithmetic of the result. */
double jump_epsilon(const struct traj_result *r);

#endif
