/* What follows an analysis: its motions, and its strata as systems of their own, jobs inside a job. */
#ifndef SGA_RUN_FOLLOW_H
#define SGA_RUN_FOLLOW_H

#include <stdbool.h>

struct job;

/* Consistent start and trajectory, as far as they are wanted; or else those of the stratum which the start lies on. */
bool answer_motion(struct job *j);
/* Without looking at strata. */
bool answer_own_motion(struct job *j);
/* Start and trajectory are forgotten; and all that answer_motion made. */
void answer_motion_drop(struct job *j);
void answer_motion_clear(struct job *j);
/* How far the start was moved, of whatever motion there is; `otherwise` where there is none. */
double answer_moved(const struct job *j, double otherwise);

/* Solves each stratum as a system of its own, and theirs in turn, within limits of depth and
 * number that are said where they are reached. False: the job was cancelled. */
bool answer_strata_solve(struct job *j);
/* After answer_own_motion failed with NO_MOTION: the motion of the stratum that the start lies on,
 * where strata are solved; otherwise the refusal names the strata. */
bool answer_motion_on_stratum(struct job *j);

#endif
