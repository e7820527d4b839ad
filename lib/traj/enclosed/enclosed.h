/* Inside the traj folder: the trajectory in balls. */
#ifndef SGA_TRAJ_ENCLOSED_H
#define SGA_TRAJ_ENCLOSED_H

#include "enclose.h"

struct flow;
struct sga_solution;
struct sizes;
struct sys_system;
struct traj_request;
struct traj_result;

/* In balls, a start that was searched for: the point of `with` (constraints, relations, bounds that it lies on) that is meant by the start `near` of the request
 * `asked` (enclosed_start), which must lie within the bounds. All are borrowed, and of the whole system, of which the motion's may be a part. */
struct enclosed_found {
    struct flow *flow;            /* of `with` */
    const struct sys_system *sys; const struct sga_solution *with; const struct traj_request *asked;
    const double *near, *low, *high;   /* low, high: by variable, or NULL */
    const expr_id *also; int alsos;    /* relations that follow from those of `with`, as far as doubles tell: 0 at the start, to its bits */
};

/* In balls, a piece of a motion with events that set something: a motion with so many bits, not with as many as the tolerances need. */
struct enclosed_piece {
    slong prec;
    const struct sys_system *sys; /* the whole system, of which the motion's may be a part */
    arb_srcptr start;             /* its variables where the piece begins, at the time t0; NULL: the start is the request's */
    const arb_struct *t0;
    int early; arb_srcptr before; /* so many samples may lie before t0, where columns would be these */
    arb_srcptr asked;             /* enclosed_nearest: values that are asked for (and their derivatives), instead of the request's; or NULL */
    const int *known_symbol; arb_srcptr known; int knowns;   /* enclosed_nearest: symbols of its constraints beside variables and time, and what they are */
    /* What the piece leaves. at: columns at the time t of the event that stopped it (_arb_vec_clear is the caller's). */
    bool first;                   /* at is to be columns at the first sample, at its time t, instead */
    arb_ptr at; int columns;
    arb_struct t;
    bool at_once, at_knot;        /* another event, or a knot of a table, may lie at the same time */
    const fmpq *knot;             /* t is this knot exactly, of a table that it is borrowed from; or NULL */
    bool wide;                    /* it ended for want of a proof: more bits may have one */
};

/* Boxes that are proved to hold the solution at the samples, with radii within the tolerances,
 * at as many bits as that takes. r->initial holds the consistent start in double, and its exact meaning is that of
 * enclosed_start. What cannot be shown ends the trajectory (`ended`) or is a shortfall; NOT_SUPPORTED for
 * what has no enclosure here. */
bool enclosed_run(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                  struct traj_result *r, struct sga_error *err);

/* Bits that are tried first, and at the most. */
slong enclosed_first_bits(double rtol);
enum { ENCLOSED_MOST_BITS = 10000 };
/* Inside this module: what is integrated (malloced members of problem; enclosed_problem_clear). */
bool enclosed_problem(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                      struct enclose_problem *problem, struct sga_error *err);
void enclosed_problem_clear(struct enclose_problem *problem);
/* The point that is meant by the start near = r->initial, in balls. Where the given values satisfy the constraints, with those that
 * were not given adapting, they stay exactly; where they had to move, it is the point of the set nearest to them; and where that is not
 * the point `near`, coordinates of Pf have the value of `near` exactly. What is solved for is proved to be one point.
 * False: INITIAL, it cannot be proved with prec bits. */
bool enclosed_start(struct flow *f, const struct sys_system *sys, const struct enclose_problem *problem, const struct sga_solution *sol,
                    const struct traj_request *rq, const double *near, const arb_t t0, slong prec, arb_ptr x, struct sga_error *err);
/* enclosed_place.c: functions (count) of variables, time and tables at (t, x), into out. False: one has no value, or a table's times are not exact. */
bool enclosed_values(const struct sys_system *sys, const arb_t t, arb_srcptr x, const expr_id *function, int count, slong prec, arb_ptr out);
/* enclosed_nearest.c: a symbol that no request can name. */
int enclosed_symbol(struct expr_store *st, const char *what, int i);
/* enclosed_place.c: the start that was searched for, in the motion's variables. */
bool enclosed_place(const struct enclosed_found *found, const struct enclose_problem *problem, const arb_t t0, slong prec, arb_ptr x, struct sga_error *err);
/* enclosed_nearest.c: x (n) becomes the nearest point, tier by tier (tiers.h), if one near `near` can be proved; where rq->asked says so with the derivatives that it has. */
bool enclosed_nearest(const struct sys_system *sys, const struct enclose_problem *problem, const struct sga_solution *sol,
                      const struct traj_request *rq, const struct sizes *sizes, const double *near, const arb_t t0, slong prec, arb_ptr x);
/* enclosed_jump.c: a constraint with a variable that no equation differentiates may jump at knots (signals_continuous allowed it). */
bool enclosed_jumps(const struct flow *f, const struct sga_solution *sol);
/* x (n) is the solution before the knot at t; tables are those beyond it, also in the flow. Variables that equations differentiate stay, the others become
 * the point of the set that double arithmetic finds them to go to, proved to be one. False: it cannot be. */
bool enclosed_jump(struct flow *f, const struct enclose_problem *problem, const struct sga_solution *sol, const arb_t t, slong prec, arb_ptr x);
/* enclosed_events.c: the request's events as what is watched (malloced members of watch, one for each event). */
void enclosed_watch(struct expr_store *st, const struct enclose_problem *problem, const struct traj_request *rq, struct enclose_watch *watch);
/* d_t e + sum_j d_j e X_j, of variables (symbols) and the field X (n each). */
expr_id enclosed_rate(struct expr_store *st, expr_id e, const int *variable, int n, int time, const expr_id *field);

#endif
