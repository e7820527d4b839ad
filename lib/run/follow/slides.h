/* Inside the follow folder: motions that slide: each choice of sides of switches, and of slides, as a system of its own, reduced when the motion may come to it. */
#ifndef SGA_RUN_SLIDES_H
#define SGA_RUN_SLIDES_H

#include <stdbool.h>

struct job;
struct sga_arena;
struct sga_solution;
struct sga_error;
struct slides;
struct sys_system;
struct traj_request;

/* Gives rq (of the job's own system; it stays where it is) its switches as modes, where sliding is asked for and some switch may jump. In mem. *out NULL: nothing
 * does. False with the job's error where it cannot be done. */
bool slides_begin(struct job *j, const struct sga_solution *solution, struct traj_request *rq, struct sga_arena *mem, struct slides **out);
/* A set of a sweep begins, of this system (the job's own, or a copy at the set's parameters) and its solution, which stay until slides_unset: the request that has its
 * switches as modes; NULL with err. Modes are those of the set: each is reduced anew, near its own motion. */
const struct traj_request *slides_set(struct slides *s, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err);
void slides_unset(struct slides *s);
/* The motion of the set is there: what is said of its slides goes into the job. */
void slides_tell(struct slides *s);
/* ok: the motion is there: what is said of its slides goes into the job. Frees the reductions. */
void slides_end(struct slides *s, bool ok);

#endif
