/* Worker threads: each takes a job, has its child process run it, and ends it. */
#ifndef SERVER_WORKER_H
#define SERVER_WORKER_H

struct config;
struct jobs;
struct metrics;
struct workers;

/* Starts config->workers threads with a child each. NULL: it could not. */
struct workers *workers_start(const struct config *c, struct jobs *js, struct metrics *m);
/* Waits for the threads; jobs must be draining. A job still running holds this up until
 * it ends or jobs_stop_running is called. */
void workers_join(struct workers *ws);

#endif
