/* A function of time given by samples: piecewise linear, or the cubic spline through them that
 * has no knots at the second and the last but one (de Boor, A Practical Guide to Splines, ch.
 * IV), so that cubic polynomials are reproduced. Two knots give a line, three a parabola. Two samples at one time are a
 * step: on each side of it is a function of its own, and at that time the later sample counts. */
#ifndef SGA_EXPR_TABLE_H
#define SGA_EXPR_TABLE_H

#include <flint/fmpq.h>
#include <stdbool.h>

#include "expr.h"

enum { EXPR_TABLE_DEGREE = 3 };     /* of the polynomials between knots, at most */
enum expr_interpolation { EXPR_LINEAR, EXPR_CUBIC };

struct expr_table {
    enum expr_interpolation kind;
    int knots;                 /* at least 2 */
    double *time;              /* increasing, but for the steps: two that are equal, neither first nor last */
    int steps;
    double (*piece)[EXPR_TABLE_DEGREE + 1];        /* by interval: coefficients of powers of t - time[k] */
    /* The interval whose polynomial is taken, also beside its ends, by who follows a motion
     * from knot to knot; -1: the one that holds t, the later one at a knot, NaN outside. */
    int at;
    /* Of samples that were given as expressions: constants of a store, times and then values, EXPR_UNDEF for doubles, which mean their decimals;
     * NULL: all are doubles. */
    const struct expr_store *store;    /* borrowed */
    expr_id *given;
    /* For long numbers (num/table_balls.h), NULL until asked for: exact times; by interval the halves of its time and of its coefficients. */
    fmpq *knot;
    double (*fine)[2 * EXPR_TABLE_DEGREE + 4];
};

/* Takes copies. */
struct expr_table *expr_table_new(enum expr_interpolation kind, int knots, const double *time, const double *value);
void expr_table_free(struct expr_table *u);      /* NULL is allowed */
/* What samples were given as, see above: knots of each, or NULL. Takes copies. */
void expr_table_given(struct expr_table *u, const struct expr_store *st, const expr_id *time, const expr_id *value);
/* The interval that holds t; its ends if t lies outside. */
int expr_table_interval(const struct expr_table *u, double t);
/* The same for an exact time; u->knot is there. */
int expr_table_interval_exact(const struct expr_table *u, const fmpq_t t);
/* The derivative of this order (0: the value) at t. Cost: constant where `at` is set, else a
 * search by halving. */
double expr_table_value(const struct expr_table *u, int order, double t);
/* The highest derivative that has no jumps; -1: the function itself has. */
int expr_table_smooth(const struct expr_table *u);

#endif
