/* The transfer matrix G(s) of E x' + F u' = A x + B u, y = C x + D u, as rational functions.
 *
 * [s E - A | B - s F] is reduced by rows over Q(s), without fractions, so that ranks are exact and nothing has to be square: y = G u where
 * the equations determine y by u and leave u free. Poles and zeros by the Smith-McMillan form (Kailath, Linear Systems, 1980, section 6.5):
 * with multiplicities, the finite ones. */
#ifndef SGA_LINEAR_TRANSFER_MATRIX_H
#define SGA_LINEAR_TRANSFER_MATRIX_H

#include <acb.h>
#include <flint/fmpz_poly.h>

#include "spectrum_of.h"

struct sga_buf;

struct transfer_equations {
    const struct linear_matrix *E, *F, *A, *B, *C, *D;   /* exact; E NULL: 1; F NULL: 0 */
};

enum transfer_status { TRANSFER_OK, TRANSFER_INPUTS_BOUND, TRANSFER_OUTPUT_FREE };

struct transfer_matrix {
    int outputs, inputs;
    fmpz_poly_struct *num, *den;   /* by rows; without common factor, the leading coefficient of den above 0 */
    int which;                 /* TRANSFER_OUTPUT_FREE: the output */
};

enum { TRANSFER_MOST = 60 };   /* states: elimination over polynomials, whose sizes grow with them */

/* INPUTS_BOUND: the equations ask something of the inputs alone; OUTPUT_FREE: output `which` is not determined by them; then t is empty.
 * Cost: the cube of the states in polynomials of their degree. */
enum transfer_status transfer_matrix_find(struct transfer_matrix *t, const struct transfer_equations *e);
void transfer_matrix_clear(struct transfer_matrix *t);

/* Degrees: num at most den (proper), below it (strictly). */
bool transfer_matrix_proper(const struct transfer_matrix *t, bool strictly);
/* "(s + 1)/(s^2 + 2)". */
void transfer_entry_text(const struct transfer_matrix *t, int output, int input, struct sga_buf *out);
/* Poles and transmission zeros, each with its multiplicity. False: the budget ended. Cost: elimination of a matrix of inputs and outputs. */
bool transfer_matrix_poles(const struct transfer_matrix *t, struct spectrum_of *poles, struct spectrum_of *zeros, const struct sga_budget *budget,
                           struct sga_error *err);
/* The entry at i omega; false: a pole. */
bool transfer_entry_at(const struct transfer_matrix *t, int output, int input, double omega, acb_t value);

#endif
