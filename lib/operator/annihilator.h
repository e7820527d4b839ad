/* Inside the operator folder only: a cyclic vector w = W z of the torsion module M of R z = 0, its
 * annihilator, and the unknowns in terms of it. */
#ifndef SGA_OPERATOR_ANNIHILATOR_H
#define SGA_OPERATOR_ANNIHILATOR_H

#include "operator.h"

struct cyclic {
    int m;                     /* the place of the 1 in W */
    struct ratio_matrix w;     /* 1 x r: W, of order 0 */
    struct ore *c;             /* r of them: z_i = c_i w in M; c_m is not used */
    struct ore e;              /* monic, e w = 0, order x->n */
};

/* From M's state form. LIMIT_MEMORY where e would be too large, UNDECIDED where no such W was found;
 * clear c in any case. Checked by multiplying out. Cost: a Krylov matrix over Q(t) and one solve. */
bool op_annihilator_find(struct cyclic *c, const struct op_state *x, const struct op_limits *limits, struct sga_error *err);
void op_annihilator_clear(struct cyclic *c);

#endif
