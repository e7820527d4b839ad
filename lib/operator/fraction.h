/* What inputs and outputs of a linear time-varying system have to do with each other: Q y = N u over k[D], k = Q(t).
 *
 * From P x = B u and y = C x + E u the unknowns x are eliminated: the rows of a unimodular U that take [P; C] to 0 give all relations of y and u
 * (Fliess, Some basic structural properties of generalized linear systems, Syst. Control Lett. 15 (1990) 391, section 3). Their module has the transfer
 * matrix Q^-1 N; a common left factor of Q and N, which belongs to what inputs do not reach, is taken out, and Q is the
 * Popov form, which is unique: so the pair depends on the transfer matrix alone. */
#ifndef SGA_OPERATOR_FRACTION_H
#define SGA_OPERATOR_FRACTION_H

#include "ore_matrix.h"

struct op_limits;
struct sga_error;

enum op_fraction_status {
    OP_FRACTION_FOUND,
    OP_FRACTION_INPUTS_BOUND,   /* the equations ask something of the inputs alone */
    OP_FRACTION_OUTPUT_OPEN,    /* output `which` is not determined by the inputs */
    OP_FRACTION_FAILED          /* err */
};

struct op_fraction {
    struct ore_matrix left, right;   /* outputs x outputs, outputs x inputs */
    int which;
};

/* P: rows x unknowns, B: rows x inputs, C: outputs x unknowns, E: outputs x inputs, of one ring. Multiplied out before it is given.
 * op_fraction_clear is due in every case. Cost: four row reductions (popov.h). */
enum op_fraction_status op_fraction_find(struct op_fraction *f, const struct ore_matrix *P, const struct ore_matrix *B, const struct ore_matrix *C,
                                         const struct ore_matrix *E, const struct op_limits *limits, struct sga_error *err);
/* Q is row reduced: N's rows are of no higher order than Q's (strictly: of a lower one). */
bool op_fraction_proper(const struct op_fraction *f, bool strictly);
void op_fraction_clear(struct op_fraction *f);

#endif
