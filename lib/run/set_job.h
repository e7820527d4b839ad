/* Inside the run folder: a set of a sweep as a request of its own, for what is not the general analysis at its values. */
#ifndef SGA_RUN_SET_JOB_H
#define SGA_RUN_SET_JOB_H

#include "buf.h"
#include "error.h"
#include "request.h"
#include "run_job.h"
#include "warnings.h"

struct set_job {
    struct job job;
    struct sga_buf text;
    struct request request;
    struct sga_warnings warnings;     /* none: what is said goes into the sweep's job's */
    struct sga_error err;
};

/* Set k of the sweep of `of`, run for these wants as a request without a sweep; what it has is s->job's until set_job_end, which is due in any case. False: s->err says why (the job may go
 * on with the next set). texts: of all sets. Cost: the set's request read, its own reduction, what is wanted. */
bool set_job_run(struct set_job *s, struct job *of, const struct request_sets *texts, int k, unsigned want);
void set_job_end(struct set_job *s);

#endif
