/* The jobs table where daemons share the store: what its files know of each other. The store decides, this table only follows.
 *
 * A job in the table either runs here (ours), or somebody here waits for it: then one thread (jobs_keeper.c) looks at its row in the
 * store (jobs_follow.c), when a hint says that something changed and once a second in any case. The same thread renews the leases of
 * our runs, and takes over what other daemons left behind (jobs_lease.c). */
#ifndef SERVER_JOBS_SHARED_H
#define SERVER_JOBS_SHARED_H

#include "jobs_parts.h"

/* In seconds: the pause between looks where no hint comes, and the least between those that hints cause. */
#define SHARED_LOOK 1.0
#define SHARED_HINT 0.1

/* -- jobs_follow.c -- */
/* Under the lock: nothing, where the job has left already. The table's reference ends. */
void shared_leave_table(struct jobs *js, struct job *job);
/* References to all jobs that run here, or that are followed; malloc'ed. Followed ones that nobody waits for leave the table. */
struct job **shared_collect(struct jobs *js, bool ours, size_t *count);
/* Looks at the rows of all followed jobs: a query for each. */
void shared_follow(struct jobs *js);

/* -- jobs_lease.c -- */
/* Under the lock: the worker that runs the job looks at what it is told. */
void shared_poke(const struct job *job);
/* Renews the leases of all our runs by one query, and hears which are lost or to be cancelled. False: the database took it not. */
bool shared_beat(struct jobs *js);
/* Jobs whose lease has run out wait again, or end after JOBS_TRIES runs. */
void shared_reap(struct jobs *js);

#endif
