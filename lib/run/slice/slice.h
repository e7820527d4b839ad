/* Inside the run folder: of the system only what the outputs depend on. */
#ifndef SGA_RUN_SLICE_H
#define SGA_RUN_SLICE_H

#include <stdbool.h>

#include "request.h"

struct job;
struct sys_system;

/* What becomes of each variable and row. */
struct slice_parts {
    unsigned char *variable;      /* by variable of the system: enum slice_fate */
    unsigned char *row;           /* by row, then by restriction: kept? */
    bool tied;                    /* see slice_decide */
};
enum slice_fate { SLICE_KEPT, SLICE_APART, SLICE_FOLLOWS };

/* Which part of a system the motion of some variables depends on.
 *
 * Equations and variables that no chain of equations links to what is needed are SLICE_APART: the system is
 * a product, each part has its motions whatever the others do. Of the rest, equations are left out, one
 * for each variable that SLICE_FOLLOWS, where they can be solved for these variables one after the other, given
 * any motion of what is kept: c v' = f with a number c that is not 0, where other velocities may stand in f; 0 = c v + g; 0 = h(v, ...) with a
 * derivative that stays away from 0 by what it looks like; c v = g with velocities of others, where nothing else is left for a row; or a block of
 * the first or second kind whose numbers have an inverse (slice_work.h). So they ask nothing of what is kept, wherever f and g have values
 * (and derivatives).
 *
 * Equations that give values do link the projection of a guess, and least norms: `tied` says that some was left out which
 * mentions what is kept. They are only where each kept variable in them is among the `fixed`; then nothing changes if
 * the fixed ones are not moved by the projection, and if the motion is unique.
 *
 * apart_only: nothing is left out that follows.
 *
 * needed, fixed, stays (of a variable that is given by value: it is kept all the same): by variable. tied: what follows from the fixed and
 * from the time alone counts as fixed. Cost: the sizes of the rows' graphs, and one gradient for each row without velocities. False: nothing
 * can be left out; then there is nothing to free. */
struct slice_wish { const unsigned char *needed, *fixed, *stays; bool apart_only, tied; };
bool slice_decide(const struct sys_system *system, const struct slice_wish *wish, struct slice_parts *parts);
void slice_parts_clear(struct slice_parts *parts);

/* Of a system with as many equations as variables, all that feeds the needed ones: blocks of the block-triangular form that they rest on.
 * What is left out (SLICE_FOLLOWS) mentions what is kept and may be of any kind: a mechanism that is driven. What is kept has its motions by itself,
 * and those of the whole system are among them; the converse is the caller's to show. False: nothing can be left out, or no matching
 * gives each variable an equation. Cost: a matching. */
bool slice_feeds(const struct sys_system *system, const unsigned char *needed, struct slice_parts *parts);

/* What of a request's system is not modelled, because the outputs do not depend on it. */
struct slice_given { int symbol; double value; };
struct model_slice {
    bool tied;
    int variables, rows;          /* of the whole system, restrictions among the rows */
    int gone, apart, rows_gone;
    int *symbol;                  /* of the variables that are gone */
    struct slice_given *given; int givens;   /* initial values for them */
};

/* Of the job's system only what its request depends on is kept, where nothing else is asked of it: j->slice, NULL where that is all. tied:
 * see above, may equations be left out where it has to be judged afterwards whether the motion is that of the whole system? */
void answer_slice(struct job *j, bool tied);
/* Likewise what slice_feeds leaves. */
void answer_slice_feeds(struct job *j);

/* The motion alone is wanted, and what answer_slice has left is more than feeds the outputs: once the whole is reduced, less of it need be moved (part.h). */
bool slice_feeds_less(const struct job *j);

/* What is had of a motion. */
enum { SLICE_MOTION = REQUEST_TRAJECTORY | REQUEST_CONSISTENT_INITIAL | REQUEST_TRADEOFF };
/* Something is wanted of the whole system, and beside it a motion that answer_slice would cut if it were wanted alone (part.h). */
bool slice_beside(const struct request *r);

#endif
