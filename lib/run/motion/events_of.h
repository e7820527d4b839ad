/* Events of a request, as a motion looks for them, and the masses that share impulses at them. */
#ifndef SGA_RUN_EVENTS_OF_H
#define SGA_RUN_EVENTS_OF_H

#include <stdbool.h>

struct job;
struct request;
struct sga_arena;
struct traj_event;
struct traj_mass;

/* In mem. */
const struct traj_event *events_of(const struct request *r, struct sga_arena *mem);
/* Whether some of them set something. */
bool events_set_any(const struct request *r);
/* The masses of a job's system, in mem; NULL: it has none, or not all coordinates are in it. */
const struct traj_mass *masses_of(const struct job *j, struct sga_arena *mem);

#endif
