/* Inside the traj folder: linear equations some of which may depend on others. */
#ifndef SGA_TRAJ_DEPENDENT_H
#define SGA_TRAJ_DEPENDENT_H

#include <stdbool.h>

/* Solves K z = b (size squared, rows of b's size; K and b are spent). What depends is left out, and unknowns that nothing determines are 0. speed: a size of
 * right sides below which (by some digits) they are 0. False: a row that depends asks for something else. Cost: size cubed. */
bool dependent_solve(double *K, double *b, double *z, int size, double speed);

#endif
