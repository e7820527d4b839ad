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
    bool *idle, *zero, *flat;     /* by event of the request, of the next piece: the motion stays at its 0; it begins there, exactly; and with the rate 0 */
    expr_id *sample;              /* of the piece: constants of its store */
    arb_ptr tau; int taus;        /* derivatives of the event's time, by direction, from the first turn to the second */
    bool setting, again;          /* where switches are modes, and an event sets something: that is set, then sides of switches are taken: the first turn; the second */
    int *twin; signed char *twin_sign;   /* by event of the request: the surface's event whose multiple its function is in this mode, with the sign; -1: none */
    char why[160];                /* not empty: the motion ends at this event, for this reason */
};

/* NULL where the request is for another arithmetic; its piece says how many bits. */
struct jump_boxed *jump_boxed_new(const struct sys_system *sys, const struct traj_request *rq);
void jump_boxed_free(struct jump_boxed *b);
/* Whether the last piece ended at an event whose function has a switch that may turn there: then it is not decided whether that passes its 0, and the result says so of all such. */
bool jump_boxed_undecided(struct jump_pass *p, const struct traj_request *rq, int event);
/* Where switches are modes: what the start of the request is, in the mode as it is written, is what the first turn begins at. */
bool jump_boxed_start(struct jump_boxed *b, const struct jump_piece *q, const struct traj_mode *mode, struct sga_error *err);
/* The piece in q is made in balls. */
void jump_boxed_first(struct jump_boxed *b, struct jump_piece *q, const struct traj_request *rq);
/* The motion ends at a surface, and is not shown to go on to its other side: events that were told there by jump_boxed_twins, in r, are not decided. */
void jump_boxed_unturned(const struct jump_boxed *b, struct traj_result *r);
/* It has ended at the surface of a switch: events whose function is a multiple of the surface's happen there too, and are told before it in its result. */
void jump_boxed_twins(struct jump_boxed *b, struct jump_piece *q, const struct traj_request *rq, const int *count, struct traj_result *piece);
/* It has ended at an event: what it left is taken over, and samples at the very time of the event, which has to be a function of time, are filled. */
void jump_boxed_end(struct jump_pass *p, const struct traj_request *rq, const struct sys_system *sys, int event);
/* jump_boxed_turn.c. After turn_land, from the mode `was`: where the motion goes on, or b->why. */
void jump_boxed_turn(struct jump_boxed *b, const struct turn *s, const struct traj_mode *was, const struct jump_at *at, const struct jump_to *to);
/* The piece in this mode begins there, with the samples from `done` on. */
bool jump_boxed_begin(struct jump_boxed *b, struct jump_piece *q, const struct turn *s, const struct traj_request *rq, int done, struct sga_error *err);
/* The whole motion: as jumps_run. */
bool jump_boxed_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err);

#endif
