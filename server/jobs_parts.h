/* The inside of the jobs table, shared by its files (table, waiting, running). */
#ifndef SERVER_JOBS_PARTS_H
#define SERVER_JOBS_PARTS_H

#include <pthread.h>
#include <stdatomic.h>

#include "jobs.h"

enum { JOBS_BUCKETS = 8192, JOBS_TRIES = 3 };

/* All but refs, and row and request as said, is guarded by the lock of the table. */
struct job {
    atomic_int refs;
    struct job_row row;              /* its end is written once, under the lock */
    char *request;                   /* canonical; NULL: on disk only. Fixed once running */
    size_t request_length;
    struct job_progress progress;
    uint64_t event;
    int stored;
    bool cancel;
    bool unsaved;                    /* its end could not be written: tried again */
    int wake_fd;                     /* of the worker that runs it; -1 */
    struct finished *finished;
    struct waiter *waiters;
    struct job *chain;               /* in its bucket */
    struct job *ahead, *behind;      /* in the queue */
    bool queued;                     /* stands in the queue */
    struct jobs *table;
};

/* Invariants under the lock: queue_count and queue_bytes are those of the list from front
 * to back; a job in the queue has status queued and is in the table; each waiter is in
 * its job's list and in `all`. */
struct jobs {
    pthread_mutex_t lock;
    pthread_cond_t work;
    const struct config *config;
    struct store *store;
    struct recent *recent;
    struct metrics *metrics;
    struct jobs_hooks hooks;
    struct job *bucket[JOBS_BUCKETS];
    struct job *front, *back;
    unsigned long queue_count, queue_bytes, running;
    struct waiter *all;
    unsigned long waiters, streams;
    unsigned long unsaved;           /* how many jobs are */
    double retry_at;                 /* sga_now() */
    bool draining, closed, stopping;
};

struct job *jobs_make(struct jobs *js, const char *id);
struct job **jobs_place(struct jobs *js, const char *id);
void jobs_enqueue(struct jobs *js, struct job *job);
void jobs_dequeue(struct jobs *js, struct job *job);
/* Something changed: resumes those who waited for it. */
void jobs_notify(struct jobs *js, struct job *job);
/* Under the lock: the ends that could not be written are given to the store once more. */
void jobs_save_again(struct jobs *js);
/* Ends a job that no queue and no worker holds any more. Not under the lock. */
void jobs_end(struct jobs *js, struct job *job, enum job_status status, const struct sga_error *err, const char *result, size_t length);

#endif
