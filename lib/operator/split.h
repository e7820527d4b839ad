/* Inside the operator folder only: what is not torsion, split off. */
#ifndef SGA_OPERATOR_SPLIT_H
#define SGA_OPERATOR_SPLIT_H

#include "popov.h"

/* U P V = [R 0; 0 0], R square of full rank, U and V unimodular. */
struct op_split {
    struct ore_matrix U, U_inverse, V, V_inverse, R;
    int rank;
};

/* Rows first, then columns through adjoints. Cost: two weak Popov forms with inverses. */
bool op_split_off(struct op_split *s, const struct ore_matrix *P, const struct op_limits *limits, struct sga_error *err);
void op_split_clear(struct op_split *s);

#endif
