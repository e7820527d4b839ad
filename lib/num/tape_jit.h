/* Inside this folder: compiled tapes. */
#ifndef SGA_NUM_TAPE_JIT_H
#define SGA_NUM_TAPE_JIT_H

#include "tape_code.h"

/* Sets t->compiled, which does what tape_run does from t->nstatic on, bit for bit (save which NaN
 * a NaN is), and gives the roots' values; the slots have theirs only where t->keep_all. False: there is no room or no
 * leave, and nothing changes. Cost: about 50 ns for each instruction. */
bool tape_compile(struct num_tape *t);

/* Compiling costs about as much as so many interpreted evaluations gain: 50, and what the two system
 * calls cost, 9000 instructions. Of Jacobians: 50 sweeps. Where the same was compiled before, as a rule, no calls are needed. */
enum { TAPE_RUNS_BEFORE = 50, TAPE_INSTRUCTIONS_BEFORE = 9000, TAPE_RUNS_REPEATED = 8 };

#endif
