/* Questions that are asked of a reduced system, as texts of the result. */
#ifndef SGA_RUN_ASK_H
#define SGA_RUN_ASK_H

#include <stdbool.h>

#include "buf.h"

struct job;

/* JSON values of the members, or empty. */
struct job_ask {
    struct sga_buf linearization, transfer, equilibria, derivation, dirac;
};

/* Where wanted: the linearization at the start, at samples, or at places. */
bool answer_linearization(struct job *j);
/* Where wanted: the transfer matrix of a system with constant coefficients, or of the linearization at the start, and its frequency response. */
bool answer_transfer(struct job *j);
/* Where wanted: points where nothing moves, proved one by one. */
bool answer_equilibria(struct job *j);
void answer_ask_clear(struct job *j);

#endif
