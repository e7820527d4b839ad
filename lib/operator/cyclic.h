/* Inside the operator folder only. */
#ifndef SGA_OPERATOR_CYCLIC_H
#define SGA_OPERATOR_CYCLIC_H

#include "ratio_matrix.h"

/* Do w, Dw, .., D^{n-1} w, D w = w' + w F, span k^n (w a row of n)? Yes is certain; no may be
 * bad luck modulo the prime. Cost: n^4. */
bool op_is_cyclic(const struct ratio_matrix *F, const struct ratio_matrix *w);

#endif
