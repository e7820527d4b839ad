/* Inside the run folder: the system that belongs to a stratum. */
#ifndef SGA_RUN_STRATA_CASE_H
#define SGA_RUN_STRATA_CASE_H

#include "answer.h"

/* Shares what it does not change with the system that it was made from. */
struct strata_case {
    struct sys_system system;
    bool own_rows;
};

/* The functions of s->where are added to the restriction; where s is a condition on
 * parameters, it is solved for one of them, which is substituted (noted in s). False:
 * UNDECIDED, where it could not be solved. */
bool strata_case_make(struct strata_case *part, const struct sys_system *system, struct stratum *s, struct sga_error *err);
void strata_case_clear(struct strata_case *part);

#endif
