/* Inside the run folder: what is asked at each set of a sweep beside its trajectory: linearizations, transfer matrices, equilibria, fits, sensitivities. */
#ifndef SGA_RUN_SETS_H
#define SGA_RUN_SETS_H

#include <stdbool.h>

struct job;

bool answer_sets_are_asked(const struct job *j);
/* j->sets: each set run as a request of its own; one that cannot be has its error. False: the job cannot go on. Cost: a reduction for each set, and what is asked. */
bool answer_sets(struct job *j);
void answer_sets_clear(struct job *j);

#endif
