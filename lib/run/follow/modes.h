/* Inside the follow folder: the modes of a motion, each reduced when the motion reaches it. */
#ifndef SGA_RUN_MODES_H
#define SGA_RUN_MODES_H

#include <stdbool.h>

struct job;
struct modes;
struct sga_arena;
struct sga_solution;
struct sys_system;
struct traj_request;

/* Gives rq (of the job's own system; it stays where it is) its modes and masses, where events set something. In mem; NULL: there are no modes. */
struct modes *modes_begin(struct job *j, struct traj_request *rq, struct sga_arena *mem);
/* A set of a sweep begins: its own start (copies at its parameters, where it has any; they stay until the next one begins). m may be NULL. */
void modes_set(struct modes *m, int set, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq);
/* What is said of the modes reached so far goes into the job. m may be NULL. */
void modes_tell(struct modes *m);
/* ok: the motion is there: what is said of its modes goes into the job. Frees their reductions. */
void modes_end(struct modes *m, bool ok);

#endif
