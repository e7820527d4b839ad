/* Inside the follow folder: a job inside a job. */
#ifndef SGA_RUN_STRATUM_FRAME_H
#define SGA_RUN_STRATUM_FRAME_H

#include "run_job.h"
#include "request.h"
#include "strata_case.h"

/* A job's own state while a stratum is solved in its place. */
struct strata_frame {
    struct job keep;
    struct request request;       /* as it was: the stratum's system stands in its place, over the same store */
    struct strata_case part;
};

/* In the form mechanical, a stratum of positions and velocities keeps the reactions of the whole system, whose
 * conditions on the fibre are taken from the set (source 3, remark 4): j, entered, gets its rows. True where there is
 * nothing to do. False with err: no such conditions exist there. */
bool strata_mechanical(struct job *j, struct sga_error *err);

/* j becomes a fresh job for the stratum's system, with the same request otherwise: the store of
 * expressions grows under both. False: no system could be made, j is as it was. */
bool strata_enter(struct job *j, struct stratum *s, struct strata_frame *f, struct sga_error *err);
/* Drops the stratum's answer; j is what it was. */
void strata_leave(struct job *j, struct strata_frame *f);

#endif
