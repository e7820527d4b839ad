/* A point of the final set as expressions see it: values of all symbols, exact where it can be, in balls that are proved to hold the
 * point otherwise. */
#ifndef SGA_LINEAR_LINEAR_PLACE_H
#define SGA_LINEAR_LINEAR_PLACE_H

#include "arena.h"
#include "ball.h"
#include "expr.h"
#include "linear_matrix.h"

struct sga_budget;
struct sga_solution;
struct sys_system;

enum linear_basis { LINEAR_EXACT, LINEAR_PROVED, LINEAR_NUMERIC };   /* the point lies on the set: by rational numbers; in balls; to all digits */

struct linear_place {
    struct sga_arena mem;
    struct expr_store *st;
    struct num_ball ball;
    expr_id *map;              /* by symbol: its exact value, a constant; EXPR_UNDEF: none, or only a ball. NULL: the point is not exact */
    double *x, t;              /* by variable: the nearest double */
    enum linear_basis basis;
};

/* Where to look. */
struct linear_guess {
    const double *x, t;        /* by variable: a point of the final set, but for rounding */
    const expr_id *exact;      /* by variable: a constant that was given, or EXPR_UNDEF; or NULL */
    const expr_id *zero;       /* functions that shall vanish at the point too */
    int zeros;
    const struct sga_budget *budget;
};

/* The point of the final set at x, moved by rounding only: first with short decimals in its place, where all constraints (and zero)
 * hold exactly then; otherwise proved in balls by the oracle's own Krawczyk step, or (LINEAR_NUMERIC) not proved. False: none is near, or the
 * budget ended; linear_place_clear is due in every case. */
bool linear_place_find(struct linear_place *p, const struct sys_system *sys, const struct sga_solution *sol, const struct linear_guess *guess);
void linear_place_clear(struct linear_place *p);

/* rows x cols values there, of expressions by rows (EXPR_UNDEF stands for 0); out is initialised here. False: one has no value. Cost: the
 * cone of all of them, once. */
bool linear_place_matrix(struct linear_place *p, const expr_id *e, int rows, int cols, struct linear_matrix *out);

/* Whether no abs, sign, min or max in the expressions may change its branch at the point: there they have no derivative, whatever
 * their gradients say. */
bool linear_place_smooth(struct linear_place *p, const expr_id *e, int count);

#endif
