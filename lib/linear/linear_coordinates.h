/* Inside the linear folder: which variables are states. */
#ifndef SGA_LINEAR_LINEAR_COORDINATES_H
#define SGA_LINEAR_LINEAR_COORDINATES_H

#include "linearize.h"

/* Variables fall into inputs, states and those that follow; the last are as many as constraints. */
struct linear_coordinates {
    int *follow; int follows;  /* solved for, in no order */
    int *state; int states;
    int moving;                /* a state that moves with the derivatives of inputs, -1: none does */
};

/* By the differentials J of the constraints at a point (constraints x variables, and more columns) and the gauge there: refuses inputs
 * that are not the freedom of the motion. Lists are in mem. False: err. */
bool linear_coordinates_choose(struct linear_coordinates *c, struct sga_arena *mem, const struct linear_request *rq, struct linear_place *place,
                               const struct linear_matrix *J, struct sga_error *err);

#endif
