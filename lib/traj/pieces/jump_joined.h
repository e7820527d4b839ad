/* Inside the traj folder: pieces joined to one motion, and where the times of its events have a limit. */
#ifndef SGA_TRAJ_JUMP_JOINED_H
#define SGA_TRAJ_JUMP_JOINED_H

#include "dd.h"
#include "jump_piece.h"

struct jump_boxed;
struct jump_fine;

/* Times as one, by their size. */
#define JUMP_SAME_TIME 1e-13

/* One motion, of all its pieces. */
struct jump_pass {
    struct traj_result r;         /* joined; `error`s are what pieces have for their own */
    double *each;                 /* rows x columns: those errors */
    double *at; int jumps, room;  /* times of events that set */
    int *count;                   /* by event: how often it did */
    bool *idle;                   /* by event, where there are modes, but in balls: along the present slide, or in the present mode, its function is 0 */
    double end_error;             /* of an accumulation's time */
    double over, over_fine;       /* errors of steps over singular positions, which all passes may have alike: in units of the tolerances, by the sizes of values */
    double direction;             /* of the motion in time: 1 or -1 */
    size_t leg_room, slide_room;
    bool stood;                   /* after the event before the last what it looks at stood still, and did so again */
    size_t happening_room;
    struct jump_boxed *boxed;     /* in balls (jump_boxed.h): rows have radii too; or NULL */
    struct jump_fine *fine;       /* in double-double (jump_fine.h): rows and happenings have texts; or NULL */
};

void jump_pass_clear(struct jump_pass *p);
/* Times so near to t are it, in double: samples there have the values before an event. 0 in double-double. */
double jump_at_once(const struct jump_pass *p, const struct traj_request *rq, double t);
/* What a piece has found, behind that of the pieces before; its samples' digits are taken over. */
void jump_join(struct jump_pass *p, const struct jump_piece *q, struct traj_result *piece);
/* What those steps may have done to a value of this column. */
double jump_over_error(const struct jump_pass *p, const struct jump_piece *q, const struct traj_result *piece, double value, int column);
/* One more, with the columns' values there; in double-double with their digits. */
void jump_tell(struct jump_pass *p, struct traj_happening what, const double *value);
void jump_tell_digits(struct jump_pass *p, struct traj_happening what, num_dd t, const num_dd *value);
/* The last happening is told once more, as event e. */
void jump_tell_again(struct jump_pass *p, int e, int direction);
/* Nothing is said beyond t. */
void jump_cut(struct jump_pass *p, double t, double direction);
/* What happened at surfaces goes: of those slides say it. */
void jump_drop_turns(struct traj_result *r, const struct traj_request *rq);
/* Whether the times of events that set have a limit: then the motion ends there. */
bool jump_accumulates(struct jump_pass *p, const struct traj_request *rq);
/* A piece begins at t; how is static, the impulse is taken over. */
void jump_add_leg(struct jump_pass *p, double t, int mode, const char *how, double moved, double *impulse, int coordinates);
/* Values of switches along a piece, and at the turn from one mode into another at (t, x), for the slides. */
void jump_note_switches(struct jump_pass *p, const struct jump_piece *q, const struct traj_mode *m, const struct traj_result *piece);
void jump_note_slides(struct jump_pass *p, const struct traj_mode *was, const struct traj_mode *to, double t, const double *x);

#endif
