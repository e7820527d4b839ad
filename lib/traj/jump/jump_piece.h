/* Inside the traj folder: a piece of a motion with events that set variables, as a request of its own. */
#ifndef SGA_TRAJ_JUMP_PIECE_H
#define SGA_TRAJ_JUMP_PIECE_H

#include "trajectory.h"

/* The request of a piece: columns are those asked for, then all variables. */
struct jump_piece {
    struct traj_request q;
    expr_id *output;
    struct traj_event *event;
    signed char *side, *all_side;  /* by event of the piece; of the request */
    unsigned char *stands;        /* by event of the request: its function stands at 0 where the piece begins */
    const bool *idle, *zero, *flat;   /* by event of the request: it is not looked for; it is from_zero; from_flat; or NULL */
    int *whole;                   /* by event of the piece: that of the request */
    double *x;
    unsigned char *given, *held;
    int n, before;                /* variables; of the piece before */
    expr_id *exact, exact_start;  /* in double-double (jump_exact.h): n, what x is and the start where they have more digits than doubles; or NULL */
    int columns;                  /* that are kept */
};

/* Of a motion that is differentiated: variables and derivatives; else the mode itself. */
struct traj_mode jump_carried(const struct traj_mode *m);
/* A piece that begins in this mode, with tolerances times `tighter`; rows are kept from rows_until on (struct traj_request). jump_piece_clear is due. */
void jump_piece_init(struct jump_piece *p, const struct traj_mode *mode, double tighter, double rows_until);
/* Its start alone, as a motion of one sample: traj_result_clear(r) is due. False: err says why there is none. */
bool jump_piece_start(const struct jump_piece *p, const struct traj_mode *mode, struct traj_result *r, struct sga_error *err);
/* It goes on in the mode `to`: its own variables and events, sides of events as they were. */
void jump_piece_turn(struct jump_piece *p, const struct traj_mode *to, double tighter);
void jump_piece_clear(struct jump_piece *p);
/* The events that are still looked for; count: by event how often it did. */
void jump_piece_events(struct jump_piece *p, const struct traj_request *rq, const int *count);

#endif
