/* Inside the traj folder: one event that sets variables, and the start after it. */
#ifndef SGA_TRAJ_JUMP_SET_H
#define SGA_TRAJ_JUMP_SET_H

#include "trajectory.h"

struct jump_slope;
struct num_tape;

struct jump {
    const struct sys_system *sys; const struct sga_solution *sol; const struct traj_request *rq;   /* borrowed */
    int n, sets;
    struct num_tape *tape;        /* of variables, time; roots: what events set, in their order, then the events' functions */
    double *in, *out;
    int *variable;                /* by symbol of the store: its place, or -1 */
    unsigned char *moving;        /* n: some equation differentiates it, or its rate is given */
    unsigned char *bound;         /* n: it is in some constraint */
    unsigned char *position;      /* n: its derivative is another variable */
    struct jump_slope *slope;     /* where the motion is differentiated, or NULL */
};

/* What happened. */
struct jump_at {
    double t;
    const double *x;              /* n: before */
    const unsigned char *fired;   /* by event: it happens now */
    const signed char *crossing;  /* by event that happens: its direction */
    double wrong;                 /* what is set is made wrong by this part of it */
    const struct traj_result *piece;   /* of which x is the end, with the sides that switches were held on; or NULL */
    const int *count;             /* by event: how often it has set something, with this time; or NULL */
};

/* Values after assignment, on their way to a start. */
struct jump_to {
    double *x;                    /* n: as they are set; then the start */
    unsigned char *changed;       /* n: set */
    unsigned char *known;         /* n: there was such a variable before */
    bool turned;                  /* modes changed: constraints may be others */
    double *impulse;              /* by coordinate, or NULL */
    bool struck;                  /* velocities had to jump by it */
    double moved;                 /* as traj_leg's */
    int way;                      /* an enum jump_way: in which the start was found */
    const char *how;              /* static */
    double *slope;                /* of the start, direction by direction, where the motion is differentiated; malloced */
    char why[256];                /* not empty: it has no derivatives, for this reason */
};

/* What happens: the piece before (from) and after (j); the same where no mode changed. */
struct jump_turn {
    struct jump *from, *j;
    const struct jump_at *before, *at;   /* the same point, in the variables of each */
};

bool jump_init(struct jump *j, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err);
void jump_clear(struct jump *j);
/* The place in the variables of `to` of variable k of `from`, by its name; -1: there is none. */
int jump_same(const struct jump *from, int k, const struct jump *to);
/* The function of event e at (t, x); and whether that is 0 but for errors of x by what the place of an event is known to. */
double jump_function(struct jump *j, int e, double t, const double *x);
bool jump_at_zero(struct jump *j, int e, double t, const double *x);
/* Whether the function of event e jumps at x. *over: also over 0, around x or along v (n, or NULL). */
bool jump_function_jumps(struct jump *j, int e, double t, const double *x, const double *v, bool *over);
/* x (n) as it is set, and by variable whether it is; by mode the place of its value, where one is set. */
bool jump_assign(struct jump *j, const struct jump_at *at, double *x, unsigned char *changed, int *choice, struct sga_error *err);
/* to->x: the start after it, and by event the side of its zero from which the motion goes on (ode_problem.event_side), and whether its function stands at 0 there. What is set
 * stays; velocities of masses take the impulse of constraints (jump_impulse.h); of the rest moves as little as
 * will do: what no equation differentiates; then velocities but no positions (variables whose derivative is a variable, and those of constraints without a
 * set variable; where that is too little, those reached from constraint to constraint); then other variables than those of constraints without a set one. To the nearest
 * point each time. */
/* The start nearest to to->x for jump_land, without impulses. Returns the way in which it was found (an enum jump_way), or -1: there is none, with err where something else was in
 * the way. */
int jump_start(struct jump *j, const struct jump_at *at, const struct jump_to *to, struct traj_initial *r, struct sga_error *why);
/* The request of that start in a way. place: 2 n zeros, which the request points to. To reach: a constraint counts as one with a set variable where
 * it has one that moves for another's sake (of w = x', where w is set, x'; so that it moves the y' that goes with it). */
enum jump_way { JUMP_HOLD_MOVING, JUMP_HOLD_POSITIONS, JUMP_REACH_POSITIONS, JUMP_HOLD_UNTOUCHED, JUMP_REACH, JUMP_WAYS };
void jump_request(const struct jump *j, const struct jump_at *at, const struct jump_to *to, int way, unsigned char *place, struct traj_request *q);
bool jump_land(const struct jump_turn *turn, struct jump_to *to, signed char *side, unsigned char *stands, struct sga_error *err);

#endif
