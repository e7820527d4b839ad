/* Inside the traj folder: exact knots of the tables, for motions in longer numbers than doubles (signals.h: in double). */
#ifndef SGA_TRAJ_KNOTS_H
#define SGA_TRAJ_KNOTS_H

#include <flint/fmpq.h>

#include "trajectory.h"

struct expr_table;
struct sys_system;

struct knots {
    const struct sys_system *sys;
    struct expr_table **table; int tables;     /* those of the system, each once */
    fmpq *knot; int count, room;  /* strictly between start and last time, in the order of the motion, each once */
    fmpq *inside;             /* count + 1: a time within each piece */
};

/* A time of the request: its exact value where it has one, else the double. */
struct instant {
    expr_id exact;
    double about;
};

static inline struct instant instant_start(const struct traj_request *rq)
{
    return (struct instant){ rq->exact_time ? rq->exact_start : EXPR_UNDEF, rq->start };
}

static inline struct instant instant_sample(const struct traj_request *rq, int k)
{
    return (struct instant){ rq->exact_time ? rq->exact_time[k] : EXPR_UNDEF, rq->times[k] };
}

/* NOT_SUPPORTED with err: a table has times that are not exact, or the motion begins or ends at one of which balls do not tell whether it is a knot;
 * knots_clear is due all the same. */
bool knots_init(struct knots *q, const struct sys_system *sys, const struct traj_request *rq, struct sga_error *err);
void knots_clear(struct knots *q);
/* Tables are their polynomials in this piece: 0 before the first knot. */
void knots_enter(const struct knots *q, int piece);
/* Tables are those functions that the samples make. */
void knots_leave(const struct knots *q);
/* Each table is its polynomial from the latest knot on that does not lie after t. False: balls do not tell which. */
bool knots_around(const struct knots *q, struct instant t);
/* before[k], by sample: how many knots come before it. False with err: balls do not tell. */
bool knots_before(const struct knots *q, const struct traj_request *rq, int *before, struct sga_error *err);

#endif
