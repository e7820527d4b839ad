/* Outputs of a motion that the equations do not determine. */
#ifndef SGA_RUN_FREE_OUTPUTS_H
#define SGA_RUN_FREE_OUTPUTS_H

struct job;

/* Warns of each output of which one of the first derivatives has a free function in it, where no rates or conditions were asked for: what is told of it is then the
 * choice of least norm. Rests on the zero oracle at points of the final set. Cost: four derivatives of each output along the field. */
void answer_warn_free_outputs(struct job *j);

#endif
