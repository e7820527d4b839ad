/* What is said of a reduced system beside its reduction. */
#ifndef SGA_RUN_PROPERTIES_H
#define SGA_RUN_PROPERTIES_H

#include <stdbool.h>

struct job;

/* Structure, as the reduction saw it, and the pencil's where the system is linear. */
bool answer_structure(struct job *j);
bool answer_kronecker(struct job *j);
void answer_structure_clear(struct job *j);
/* Symmetries, as far as they are wanted. The oracle is not used after the clearing. */
bool answer_symmetries(struct job *j);
void answer_symmetries_clear(struct job *j);
/* Signs of symbolic parameters without which no point of the final set was found. */
bool answer_signs(struct job *j);
void answer_signs_clear(struct job *j);

#endif
