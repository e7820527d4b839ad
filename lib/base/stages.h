/* The stages of an explicit Runge-Kutta step, as integrators describe them and machine code runs them. */
#ifndef SGA_BASE_STAGES_H
#define SGA_BASE_STAGES_H

#include <stdbool.h>
#include <stddef.h>

/* Nonzero coefficients of a linear combination of stages, in ascending order of these. */
struct sga_row {
    int count;
    int stage[12];
    double a[12];
};

enum { SGA_STAGES_MOST = 12 };

/* Stage s = 1 .. count - 1 is at time t + c[s] h and y_s = x + h sum a[s] k, whose last term is that of stage
 * s - 1: k_s is the field there. All vectors lie in one block whose places are counted in doubles from k_0:
 * k_s at s * stride, x at `x`, and y_s, for the stages from `keep` on, at y + (s - keep) * stride; with an odd number of
 * variables a 0 follows each of them. The block is at a multiple of 16 bytes, and strides and places are even.
 * With `aside` the field is wrong by a rounding, on purpose: k_s is it times 1 + 2^-52 in variables 0, 2, ..., 1 - 2^-52 in
 * the others. Rounding is part of the contract: y_s = (x + h (a_0 k_0 + a_1 k_1 + ...)) + (h a_last) k_last, sums from the left. */
struct sga_stages {
    int count;                 /* at most SGA_STAGES_MOST */
    const double *c;
    const struct sga_row *row;
    size_t stride, x, y;
    int keep;
    bool aside;
};

/* Such a step as machine code, for one field: where needs_time, time[s] is to be that of stage s;
 * then run(slots, block, rest, place, h) gives all k_s and the y_s kept, and rests numbers for each stage at
 * rest + (s - 1) rests, which say whether the field has its value there. */
struct sga_stage_code {
    void (*run)(double *slots, double *block, double *rest, double *place, double h);
    double *slots, *rest, *place, *time;
    bool needs_time;
};

#endif
