/* Inside this folder: programs of series run, by a loop or by machine code. */
#ifndef SGA_NUM_JET_MACHINE_H
#define SGA_NUM_JET_MACHINE_H

#include "jet_code.h"

struct num_jet_programs;

struct jet_machine {
    struct sga_exec *memory;          /* borrowed; NULL: no code is to be made */
    bool asked, has;                  /* there is a program */
    struct num_jet_programs *kept;    /* borrowed: programs of jets before; NULL: none are kept */
    bool shared;                      /* acts and code are theirs */
    struct jet_series series;
    long runs;                        /* by the loop */
    double scale;                     /* which the slots are for */
    const void *base;                 /* of the code; NULL: not made */
    size_t bytes;                     /* of it */
    /* The coefficients from order 1 to the last one into series[variable + order count]. */
    void (*run)(double *slot, double *series, double *unused, long last);
};

/* As num_jet_along, by the program. */
bool jet_machine_along(struct jet_machine *m, int order, double t, double scale, double *series);
/* The program, made or found among those that are kept. */
void jet_machine_begin(struct jet_machine *m, const struct jet_plan *p, int order, int count, const double *row, size_t stride);
/* Gives up the program, of this plan: to those that are kept, where it has become code. */
void jet_machine_clear(struct jet_machine *m, const struct jet_plan *p);

/* Compiling costs about as much as so many runs of the loop. */
enum { JET_RUNS_BEFORE = 24 };

#endif
