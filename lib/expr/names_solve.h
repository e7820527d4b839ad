/* Inside the expression folder only: SOLVE nodes as plain arithmetic. */
#ifndef SGA_EXPR_NAMES_SOLVE_H
#define SGA_EXPR_NAMES_SOLVE_H

#include "expr.h"

/* Replaces the SOLVE nodes under the roots by the steps of Gaussian elimination, in
 * place. Pivots are chosen among entries that are not the constant 0: constants first,
 * then short rows. (The numeric code pivots by value instead, so it can go on where one
 * of these symbolic pivots happens to vanish.) Cost: up to m^3 nodes for a dense solve.
 * False: a structurally singular matrix, or the store's limit was met (its error is set). */
bool expr_write_out_solves(struct expr_store *st, expr_id *roots, int nroots);

#endif
