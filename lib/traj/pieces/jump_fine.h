/* Inside the traj folder: motions with events that set variables in double-double. Pieces, their events and samples are made in these numbers by traj_run; here is what lies between them: the
 * state at the end of one, what is set, the start of the next one, and derivatives there (jump_slope.h has the formulas and, in double, judges whether they hold). */
#ifndef SGA_TRAJ_JUMP_FINE_H
#define SGA_TRAJ_JUMP_FINE_H

#include <arb.h>

#include "dd.h"
#include "jump_piece.h"

struct jump_at;
struct jump_to;
struct num_tape;
struct turn;

struct jump_fine {
    num_dd *time;                 /* of the samples */
    num_dd t, *x;                 /* at an event, and where the motion goes on: of all variables of the mode */
    double wrong;                 /* what is set, and when, is made wrong by this part of it */
    expr_id *exact, *sample;      /* of the piece: constants of its store */
};

/* Whether events set something, or a motion that slides is differentiated, in double-double. */
bool jump_fine_any(const struct traj_request *rq);
/* NULL where they do not. */
struct jump_fine *jump_fine_new(const struct sys_system *sys, const struct traj_request *rq, double wrong);
void jump_fine_free(struct jump_fine *f);
/* The first piece starts where the request says. */
void jump_fine_first(struct jump_piece *q, const struct traj_request *rq);
/* Where switches are modes: t and x are those of the start, in the mode as it is written. */
bool jump_fine_start(struct jump_fine *f, const struct jump_piece *q, const struct traj_mode *mode, struct sga_error *err);
/* t and x of the last happening of a piece with so many variables. False: it has no digits. */
bool jump_fine_end(struct jump_fine *f, const struct traj_result *piece, int all);
/* jump_fine_turn.c. After turn_land: t and x where the motion goes on. False with err: NOT_SUPPORTED where the nearest point is not told to these digits. */
bool jump_fine_turn(struct jump_fine *f, const struct turn *s, const struct jump_at *at, const struct jump_to *to, struct sga_error *err);
/* The piece in this mode begins there, with the samples from `done` on. */
bool jump_fine_begin(struct jump_fine *f, struct jump_piece *q, const struct turn *s, int done, int samples, struct sga_error *err);
/* Roots of a tape at (t, x) into out; speed (or NULL): by input what they change by, and then into rate what the roots do. False: one has no value. */
bool jump_fine_evaluate(const struct num_tape *tape, int inputs, num_dd t, const num_dd *x, const num_dd *speed, int speeds, num_dd *out, num_dd *rate, int roots);
/* Inside this module: the middle of a ball; and a constant of the store. */
num_dd jump_fine_ball(const arb_t a);
expr_id jump_fine_constant(struct expr_store *st, num_dd v);
/* |a - b| of two texts. */
double jump_fine_apart(const char *a, const char *b);
/* A text again with the digits that this error leaves; takes the old one. */
char *jump_fine_text(char *text, double error);

#endif
