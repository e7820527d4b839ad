/* Inside the run folder: the motion of a part of the system, beside what is said of the whole. */
#ifndef SGA_RUN_PART_H
#define SGA_RUN_PART_H

#include <stdbool.h>

struct job;

/* After the reduction, and after the motion: what was left out of the system, if anything, changes nothing. */
bool job_slice_holds(const struct job *j);

/* After what is said of j's system, before its motion: j->part, where outputs need less than the whole (slice.h), with
 * the motion done: a job of its own for the same text, which wants nothing but the motion. Where that does not succeed, j makes
 * the whole motion itself, as if nothing had been tried. False: the job cannot go on. Cost: the request read once more, the part's own
 * reduction, its motion. */
bool job_part(struct job *j);
void job_part_clear(struct job *j);

#endif
