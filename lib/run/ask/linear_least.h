/* Inside the ask folder: freedom that no input names, taken of least norm. */
#ifndef SGA_RUN_LINEAR_LEAST_H
#define SGA_RUN_LINEAR_LEAST_H

#include <stdbool.h>

struct ask_work;

/* From now on the motion is x' = X* + sum_i u_i' Y*_i, u the inputs that are variables: of all velocities of the final set with these derivatives
 * of the inputs the one of least Euclidean norm, as trajectories take it (gauge_choice.h). s->rq.sol is a copy of the job's solution, in s->mem, with
 * X* for its field and Y*_i for its gauge fields, so that the inputs are the freedom; s->ports tells it. Nothing where no freedom is left.
 * False with j->err: INPUTS (an input whose derivative is determined, or that depends on others), GAUGE (it is too large as expressions). Cost: a choice of the
 * gauge for each input and one more. */
bool linear_least_norm(struct ask_work *s);

#endif
