/* First integrals whose drift is reported. */
#ifndef SGA_RUN_JOB_INTEGRALS_H
#define SGA_RUN_JOB_INTEGRALS_H

#include "expr.h"
#include "points_space.h"

struct job_integrals {
    expr_id *expr;
    int *given;                   /* index into the request's, or -1: the energy */
    enum points_truth *truth;     /* POINTS_ZERO: constant along the motion */
    int count;
};

#endif
