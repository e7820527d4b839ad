/* Inside the traj folder: motions with events that set variables in balls.
 *
 * Which events happen, modes, and the ways in which a start is found after them are those of double (jump_pass.h); everything that has a value is proved: each piece is a
 * motion in balls from a box, at a time in a ball, to the ball of time in which the event's function is shown to change its sign; what is set, impulses and the
 * start beyond lie in balls again. Where something cannot be shown the motion ends there (`not_enclosed`), or more bits can: the whole motion is made with more
 * until its radii are within the tolerances. */
#ifndef SGA_TRAJ_JUMP_BOXED_H
#define SGA_TRAJ_JUMP_BOXED_H

#include "enclosed.h"
#include "jump_piece.h"

struct jump;
struct jump_at;
struct jump_pass;
struct jump_to;
struct turn;

struct jump_boxed {
    struct enclosed_piece piece;
    arb_ptr time; int samples;    /* of the motion */
    arb_ptr x; int n;             /* where it goes on: all variables of the mode, */
    arb_struct t;                 /* then */
    arb_ptr before; int columns;  /* columns at the last event */
    bool *idle, *zero;            /* by event of the request, of the next piece: the motion stays at its 0; it begins there, exactly */
    expr_id *sample;              /* of the piece: constants of its store */
    char why[160];                /* not empty: the motion ends at this event, for this reason */
};

/* NULL where the request is for another arithmetic; its piece says how many bits. */
struct jump_boxed *jump_boxed_new(const struct sys_system *sys, const struct traj_request *rq);
void jump_boxed_free(struct jump_boxed *b);
/* The piece in q is made in balls. */
void jump_boxed_first(struct jump_boxed *b, struct jump_piece *q, const struct traj_request *rq);
/* It has ended at an event: what it left is taken over, and samples at the very time of the event, which has to be a function of time, are filled. */
void jump_boxed_end(struct jump_pass *p, const struct traj_request *rq, const struct sys_system *sys, int event);
/* jump_boxed_turn.c. After turn_land: where the motion goes on, or b->why. */
void jump_boxed_turn(struct jump_boxed *b, const struct turn *s, const struct jump_at *at, const struct jump_to *to);
/* The piece in this mode begins there, with the samples from `done` on. */
bool jump_boxed_begin(struct jump_boxed *b, struct jump_piece *q, const struct turn *s, const struct traj_request *rq, int done, struct sga_error *err);
/* The whole motion: as jumps_run. */
bool jump_boxed_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err);

#endif
