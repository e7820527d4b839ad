/* Inside the run folder: what a job goes through. */
#ifndef SGA_RUN_STAGE_LIST_H
#define SGA_RUN_STAGE_LIST_H

#include <stdbool.h>

#include "run_job.h"

struct job;
struct job_stage;

/* What is said of the system, and then what follows it along a motion. */
extern const struct job_stage job_stages[];

/* Before the first of them: refuses what cannot be had, and sets where the request starts. */
bool job_prepare(struct job *j);

#endif
