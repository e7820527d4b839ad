/* Inside the slice folder: the graph of equations and variables, and which equation gives which variable. */
#ifndef SGA_RUN_SLICE_WORK_H
#define SGA_RUN_SLICE_WORK_H

#include <stdbool.h>
#include <stddef.h>

struct sys_system;

/* Lists by row, one after the other: those of row r are to[start[r]] .. to[start[r + 1] - 1]. */
struct slice_lists {
    int *start, *to;
    size_t count, cap;
};

struct slice_work {
    const struct sys_system *sys;
    int n, rows;                        /* rows: with the restrictions, which come last */
    int *variable_of;                   /* by symbol: variable, or -1 */
    struct slice_lists mentions;        /* by row: variables */
    struct slice_lists users;           /* by variable: rows */
    struct slice_lists candidates;      /* by row: variables that it can be solved for */
    struct slice_lists behind;          /* by row with velocities: variables that are a number times themselves in it, without a velocity of theirs */
    bool *algebraic;                    /* by row: it has no velocities */
    int *row_of, *variable;             /* by variable: the row that gives it, or -1; by row: the variable */
    bool *linked;                       /* by row: it belongs to what is needed */
    bool *kept;                         /* by variable */
    int *queue, queued;
};

void slice_lists_push(struct slice_lists *l, int v);
void slice_lists_clear(struct slice_lists *l);

/* For which variables v each linked row can be solved, given any motion of the others: c v' = f with a number c (other velocities may stand
 * in it), 0 = c v + g, or 0 = h(v, others) where h has a value for every v and its derivative stays away from 0 by what it looks like, as
 * in v + v^3 = g. none: for no variable. Cost: one gradient for each row without velocities. */
void slice_find_candidates(struct slice_work *w, bool none);
/* w->behind, in the same way: v = g(others, their velocities). Cost: one gradient for each row with velocities. */
void slice_find_behind(struct slice_work *w);

/* w->row_of, w->variable: a largest matching of candidates of which nothing rests on itself. Circles stay where they are a block of velocities,
 * or of variables without, with numbers that have an inverse (shown modulo a prime); the rows of others give nothing.
 * more: rows that would be left over may give what is in w->behind, too. */
void slice_assign(struct slice_work *w, bool more);

/* The variable of row r is given by value: it is no velocity that the row gives. */
bool slice_by_value(const struct slice_work *w, int r);

/* By variable: it is `fixed`, or (more) follows by value from such and from the time alone, so that no projection moves it. */
void slice_settled(const struct slice_work *w, const unsigned char *fixed, bool more, bool *settled);

#endif
