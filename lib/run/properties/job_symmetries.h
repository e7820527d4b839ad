/* Symmetries of one job. */
#ifndef SGA_RUN_JOB_SYMMETRIES_H
#define SGA_RUN_JOB_SYMMETRIES_H

#include "sym.h"

struct job_symmetries {
    struct sym_work *work;
    struct sym_check *check;      /* by candidate of the request */
    struct sym_result found;
    bool has, time;
};

#endif
