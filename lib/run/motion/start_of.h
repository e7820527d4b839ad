/* The start's equations and bounds, for motions. */
#ifndef SGA_RUN_START_OF_H
#define SGA_RUN_START_OF_H

struct request;
struct sga_arena;
struct traj_request;

/* r->relation and what belongs to it, and r->low and high: of the request, from mem. */
void answer_start_of(const struct request *from, struct sga_arena *mem, struct traj_request *r);

#endif
