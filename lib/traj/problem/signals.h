/* Inside the traj folder: tables in a motion. Between knots a table is a polynomial; at knots
 * some derivative jumps, so steps end there, and what jumps there must not move the state. */
#ifndef SGA_TRAJ_SIGNALS_H
#define SGA_TRAJ_SIGNALS_H

#include "trajectory.h"

struct num_ball;

/* Do the constraints and the events depend on derivatives without jumps only, the field that is followed (and
 * the outputs) on the next one at most? Otherwise the motion would jump: NOT_SUPPORTED says where. moving: variables that do not jump; constraints
 * that have others may jump, and these follow (ode_problem.jump). NULL: none may. */
bool signals_continuous(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                        const expr_id *field, const unsigned char *moving, struct sga_error *err);
/* Does e jump where a table or a derivative of one does? */
bool signals_jump(const struct sys_system *sys, expr_id e);
/* Has e, or one of its derivatives by time up to order `more`, a jump at t, at a knot to the rounding of t? */
bool signals_bend(const struct sys_system *sys, expr_id e, int more, double t);
/* Symbols of tables get their values at t, in double. */
void signals_set(const struct sys_system *sys, double t, struct num_ball *b);
/* The knots of all tables between start and the last time, in the order of the motion, each once.
 * The caller frees them. */
double *signals_knots(const struct sys_system *sys, const struct traj_request *rq, int *count);
/* Tables are their polynomials between these times; NaN: each is itself. */
void signals_between(const struct sys_system *sys, double from, double to);
/* They are those from the request's start to the first knot of its motion, on whichever side of a knot that lies. */
void signals_ahead(const struct sys_system *sys, const struct traj_request *rq);

#endif
