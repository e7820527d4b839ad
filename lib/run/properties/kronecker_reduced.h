/* The Kronecker structure of a pencil of any size, as far as the reduction shows it. */
#ifndef SGA_RUN_KRONECKER_REDUCED_H
#define SGA_RUN_KRONECKER_REDUCED_H

#include <stdbool.h>

struct job;
struct pencil;
struct pencil_structure;

/* The structure without its spectrum, proved: of a pencil that is regular, or whose minimal indices are all 0 (combinations of unknowns that no
 * equation has, and of equations that have no unknown: as many as are free, and as are too many). Then the dimensions of the generations are those
 * of the infinite blocks alone. False: other minimal indices, or the reduction was not exact; out is empty. Cost: none for a square pencil without
 * freedom, else two sparse eliminations. */
bool kronecker_reduced(const struct job *j, const struct pencil *p, struct pencil_structure *out);
/* Whether that is this structure, which is then proved. */
bool kronecker_shown(const struct job *j, const struct pencil *p, const struct pencil_structure *s);

#endif
