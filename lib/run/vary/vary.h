/* Motions differentiated by parameters and initial values. */
#ifndef SGA_RUN_VARY_H
#define SGA_RUN_VARY_H

#include <stdbool.h>

struct job;

/* Where trajectory.sensitivities asks for them: derivatives of the motion beside its samples, into j->sensitivities. */
bool answer_sensitivities(struct job *j);
/* Where wanted: parameters and initial values from data, into j->fit. */
bool answer_fit(struct job *j);
void answer_vary_clear(struct job *j);

#endif
