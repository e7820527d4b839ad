/* Inside the traj folder: where functions end. */
#ifndef SGA_TRAJ_DOMAIN_ENDS_H
#define SGA_TRAJ_DOMAIN_ENDS_H

#include "field.h"

/* Adds expressions that are not negative wherever the roots have values, by the intervals of their functions (sqrt(u): u; acos(u): u + 1 and
 * 1 - u), each once; none whose sign is settled by its shape. Cost: the nodes below the roots. */
void domain_ends(struct expr_store *st, const expr_id *root, int roots, struct field_list *l);

#endif
