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
    enum metrics_stage stage;        /* for the metrics, with the time since when */
    double stage_since;
    char request_id[72], traceparent[64];    /* of the request that made it, "" for one of an earlier life */
    uint64_t event;
    int stored;
    bool cancel;
    bool unsaved;                    /* its end could not be written: tried again */
    int wake_fd;                     /* of the worker that runs it; -1 */
    struct finished *finished;
    struct waiter *waiters;
    struct job *chain;               /* in its bucket */
    struct account *account;         /* on which it waits and runs */
    struct job *ahead, *behind;      /* in the queue of its account */
    bool queued;                     /* stands in the queue */
    struct jobs *table;
};

/* Invariants under the lock: queue_count and queue_bytes are those of all accounts' lists;
 * an account is in the ring exactly while its list is not empty; a job in the queue has status queued and is in the table; each waiter is in
 * its job's list and in `all`. */
struct jobs {
    pthread_mutex_t lock;
    pthread_cond_t work;
    const struct config *config;
    struct store *store;
    struct memory_cache *memory_cache;
    struct metrics *metrics;
    struct jobs_hooks hooks;
    struct job *bucket[JOBS_BUCKETS];
    struct account *accounts, *everyone, *turn;   /* all; of those without a token; the next of the ring */
    unsigned long queue_count, queue_bytes, running;
    struct waiter *all;
    unsigned long waiters, streams;
    unsigned long unsaved;           /* how many jobs are */
    double retry_at;                 /* sga_now() */
    bool draining, closed, stopping;
};

struct job *jobs_make(struct jobs *js, const char *id, struct account *account);
struct job **jobs_place(struct jobs *js, const char *id);
/* -- jobs_queue.c, under the lock -- */
void jobs_enqueue(struct jobs *js, struct job *job);
void jobs_dequeue(struct jobs *js, struct job *job);
/* Takes the job whose turn it is out of the queue; NULL: none waits. */
struct job *jobs_next(struct jobs *js);
/* The job comes to a stage. */
void jobs_stage(struct job *job, enum metrics_stage stage);
/* A job of the account has ended. */
void jobs_settle(struct job *job, double seconds);
/* Something changed: resumes those who waited for it. */
void jobs_notify(struct jobs *js, struct job *job);
/* Under the lock: the ends that could not be written are given to the store once more. */
void jobs_save_again(struct jobs *js);
/* Ends a job that no queue and no worker holds any more. Not under the lock. */
void jobs_end(struct jobs *js, struct job *job, enum job_status status, const struct sga_error *err, const char *result, size_t length);

#endif
