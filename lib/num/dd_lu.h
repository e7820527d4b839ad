/* Small dense linear solves in double-double: LU with partial pivoting. As lu.h. */
#ifndef SGA_NUM_DD_LU_H
#define SGA_NUM_DD_LU_H

#include "dd.h"

bool num_dd_lu_factor(num_dd *a, int *perm, int m);
/* x = A^-1 b; x and b must not overlap. */
void num_dd_lu_solve(const num_dd *lu, const int *perm, int m, const num_dd *b, num_dd *x);

#endif
