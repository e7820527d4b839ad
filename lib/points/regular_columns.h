/* Whether the differentials are independent in as many columns as there are constraints. */
#ifndef SGA_POINTS_REGULAR_COLUMNS_H
#define SGA_POINTS_REGULAR_COLUMNS_H

#include <stdbool.h>

struct points_jacobian;
struct points_point;

/* The entries are those at the point (points_jacobian_entries). True: proved, in the balls. False: not, or its factors would be too full (least_singular.h).
 * column (constraints): variables. Cost: a sparse factor of B B^T, B the matrix. */
bool points_columns_regular(struct points_jacobian *j, struct points_point *p, int *column);

#endif
