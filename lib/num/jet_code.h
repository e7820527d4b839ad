/* Inside this folder: series as a program without branches. */
#ifndef SGA_NUM_JET_CODE_H
#define SGA_NUM_JET_CODE_H

#include "jet_maker.h"

/* The series along x' = scale f(x, t), all orders in one run: what the recurrences do, but sums are added in another order,
 * and beyond coefficient 5 divisions are multiplications by reciprocals, so values differ by roundings. */
struct jet_series {
    int count, most;           /* variables; highest order */
    int slots, stride;         /* slots of a row */
    int part;                  /* the slot of scale / 0, scale / 1, ... */
    int whole, reciprocal;     /* those of 0, 1, 2, ... and of 1/1, 1/2, ... */
    double *memory, *slot;     /* registers, slots; these begin with the rows' coefficients */
    struct jet_act *act;
    size_t acts;
};

/* row: the interpreter's rows, of which what depends on no input is taken over. The first `count` inputs follow the
 * roots, the next one is the time. False: an instruction that only the recurrences know, or too many acts. */
bool jet_series_make(struct jet_series *q, const struct jet_plan *p, int order, int count, const double *row, size_t stride);
/* The numbers that a program works on, into new memory; the program is made. */
void jet_series_fill(struct jet_series *q, const struct jet_plan *p, const double *row, size_t stride);

#endif
