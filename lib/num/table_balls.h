/* Tables of samples (expr/table.h) in longer numbers than doubles: exact times, and between them the polynomials of the same
 * interpolation, in balls or in double-double. Samples are what was given: "1/3", and 1/10 for the number 0.1. */
#ifndef SGA_NUM_TABLE_BALLS_H
#define SGA_NUM_TABLE_BALLS_H

#include <arb.h>

#include "dd.h"
#include "table.h"

enum { NUM_TABLE_PIECE = EXPR_TABLE_DEGREE + 2 };      /* numbers of a piece: its time, the coefficients of powers of t less that */

struct num_table_balls {
    const struct expr_table *table;
    slong prec;
    arb_ptr value, slope;      /* by sample; slope: of the spline, NULL for lines */
};

/* u->knot, where it is missing. The place of the first sample whose time is no rational number, or equal to that of its neighbour as a double only;
 * -1: none. Cost: about a microsecond a sample. */
int num_table_exact(struct expr_table *u);
/* Of a table whose u->knot is there, with prec bits: each ball encloses what the samples make exactly. Cost: some 20 operations a sample. */
void num_table_balls_init(struct num_table_balls *b, const struct expr_table *u, slong prec);
void num_table_balls_clear(struct num_table_balls *b);
/* out (NUM_TABLE_PIECE): the piece of interval k. */
void num_table_balls_piece(const struct num_table_balls *b, int k, arb_ptr out);
/* The derivative of this order at t, from a piece. */
void num_table_balls_value(arb_t r, arb_srcptr piece, int order, const arb_t t, slong prec);

/* u->fine, where it is missing; u->knot is there. */
void num_table_fine(struct expr_table *u);
/* A ball of the derivative of this order at t, whose midpoint lies in the table's interval. False: the times are not exact (num_table_exact), and it is the value
 * in double with room for its rounding, not proved. Cost: num_table_fine, once; then some multiplications. */
bool num_table_around(arb_t r, struct expr_table *u, int order, const arb_t t, slong prec);
/* As expr_table_value, in double-double where u->fine is there, otherwise to the digits of double. */
num_dd num_table_value(const struct expr_table *u, int order, num_dd t);

#endif
