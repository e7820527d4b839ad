/* The stage `derivation`: the reduction as steps that a reader can check one by one.
 *
 * The steps are made of what the reduction recorded: which combination of equations and tangencies each constraint is, which velocities were
 * determined when (sga_solution.rate), what was divided by, which branch was followed. Nothing is solved anew. */
#ifndef SGA_RUN_DERIVATION_H
#define SGA_RUN_DERIVATION_H

#include <stdbool.h>

struct job;

/* j->ask->derivation. Needs the texts. False: j->err. Cost: the combinations' terms, one gradient for each constraint and each sum. */
bool answer_derivation(struct job *j);

#endif
