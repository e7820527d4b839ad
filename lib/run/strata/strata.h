/* The list of strata. */
#ifndef SGA_RUN_STRATA_H
#define SGA_RUN_STRATA_H

#include <stdbool.h>

struct job;

/* Factors of pivots that can vanish on the final set, and branches not followed; where the
 * strata shall be solved, also pivots' zeros off the final set. */
bool answer_strata(struct job *j);
void answer_strata_clear(struct job *j);

#endif
