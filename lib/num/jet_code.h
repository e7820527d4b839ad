/* Inside this folder: compiled series. */
#ifndef SGA_NUM_JET_CODE_H
#define SGA_NUM_JET_CODE_H

#include "exec.h"
#include "jet_plan.h"

/* Machine code of the orders 1 .. order - 1 of series in double: at[k](row, NULL, NULL) does
 * what the recurrences do at order k, with the same operations in the same order. */
struct jet_machine {
    struct sga_exec *memory;          /* borrowed; NULL: none is to be made */
    long runs;                        /* of order 1, interpreted */
    const void *base;                 /* NULL: not made */
    void (**at)(double *row, double *out, double *rest);   /* by order */
};

/* False: an instruction that only the interpreter knows, too much code, no room or no leave. */
bool jet_compile(struct jet_machine *m, const struct jet_plan *p, int order, size_t stride);
void jet_machine_clear(struct jet_machine *m);

/* Compiling costs about as much as so many interpreted series gain. */
enum { JET_RUNS_BEFORE = 24 };

#endif
