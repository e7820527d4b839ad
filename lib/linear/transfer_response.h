/* A transfer matrix on the imaginary axis, as doubles. */
#ifndef SGA_LINEAR_TRANSFER_RESPONSE_H
#define SGA_LINEAR_TRANSFER_RESPONSE_H

#include "linearize.h"
#include "transfer_matrix.h"

struct transfer_response {
    int outputs, inputs;
    double *number;            /* re, im by output and input; NAN at a pole, where it is not told from one, or beyond the doubles */
    double error;              /* a bound of |true - written| / |true| over all entries that are numbers; INFINITY: not known */
};

void transfer_response_init(struct transfer_response *r, int outputs, int inputs);
void transfer_response_clear(struct transfer_response *r);
/* G(i omega), from rational functions or from a state form: C (i omega - A)^-1 B + D in balls. */
void transfer_response_exact(struct transfer_response *r, const struct transfer_matrix *t, double omega);
void transfer_response_enclosed(struct transfer_response *r, const struct linearization *l, double omega);

#endif
