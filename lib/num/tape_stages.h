/* Inside this folder: a tape's field in all stages of a Runge-Kutta step, as one piece of machine code. */
#ifndef SGA_NUM_TAPE_STAGES_H
#define SGA_NUM_TAPE_STAGES_H

#include "stages.h"

struct num_tape;

struct tape_stages {
    struct sga_stages plan;    /* what it is for */
    long asked;                /* steps so far without machine code */
    bool refused;
    void (*run)(double *slots, double *block, double *rest, double *place, double h);
    double *place;                 /* h twice, the stages' times, the coefficients twice each */
    bool needs_time;
};

/* Releases what t->stages points to, and the code. */
void tape_stages_drop(struct num_tape *t);

#endif
