/* The inside of the jobs table, shared by its files (table, waiting, running). */
#ifndef SERVER_JOBS_PARTS_H
#define SERVER_JOBS_PARTS_H

#include <pthread.h>
#include <stdatomic.h>

#include "jobs.h"
#include "metrics.h"

enum { JOBS_BUCKETS = 8192, JOBS_TRIES = 3, JOBS_NOTED = 4096 };

/* All but refs, and row and request as said, is guarded by the lock of the table.
 *
 * An end is told to nobody before it is on disk, so that no crash takes it back: until then the
 * job is shown as it was, at the stage "storing". */
struct job {
    atomic_int refs;
    struct job_row row;              /* as everybody may see it; its end is written once, under the lock */
    struct store_submission *order;  /* on its way to the store; NULL: there is none */
    struct job_row end;              /* how it ended, on its way to the disk */
    struct finished *ending;         /* the same as text; NULL: it has not ended, or is told */
    char *request;                   /* canonical; NULL: on disk only. Fixed once running */
    size_t request_length;
    struct job_progress progress;
    enum metrics_stage stage;        /* for the metrics, with the time since when */
    double stage_since;
    double began;                    /* sga_now() of its start; 0: it did not run. The clock of the day may step */
    char request_id[72], traceparent[64];    /* of the request that made it, "" for one of an earlier life */
    uint64_t event;
    int stored;
    bool cancel;
    bool killed;                     /* its process was, once */
    bool unsaved;                    /* its end could not be written: tried again. ending stays */
    unsigned pause, waits;           /* after how many looks, the last time, and how many of them are to come */
    int wake_fd;                     /* of the worker that runs it; -1 */
    /* Where daemons share the store: */
    bool ours;                       /* it runs here, or its end is on its way */
    bool lost;                       /* it does not any more: the worker is told */
    bool gone;                       /* see struct job_look, and below */
    enum submit refused;
    const char *quota;
    long retry;
    struct finished *finished;
    struct waiter *waiters;
    struct job *chain;               /* in its bucket */
    struct account *account;         /* on which it waits and runs; fixed once it runs */
    struct interest *interests;      /* who asked for it, each once */
    int joining;                     /* of those, how many are not on disk yet */
    struct job *ahead, *behind;      /* in the queue of its account */
    bool queued;                     /* stands in the queue */
    struct jobs *table;
};

/* Invariants under the lock: queue_count and queue_bytes are those of all accounts' lists;
 * an account is in the ring exactly while its list is not empty; a job in the queue has status queued and is in the table; each waiter is in
 * its job's list and in `all`; a job in the table has not ended, as far as anybody was told. */
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
    long unable;                     /* workers without a child */
    unsigned long helping;           /* processes beside those that run jobs (helpers.h) */
    struct waiter *all;
    unsigned long waiters, streams;
    uint32_t noted[JOBS_NOTED];      /* digests of interests in ended jobs that were written lately */
    unsigned long unsaved;           /* how many jobs are */
    unsigned long ending, ending_bytes;    /* jobs with an end that is not on disk, and what they take */
    unsigned long prunes;
    double retry_at;                 /* sga_now() */
    bool draining, leaving, brief, closed, stopping;
    /* Where daemons share the store: */
    bool shared, keeps;              /* keeps: the thread runs */
    char name[112];                  /* of this daemon, unlike all others */
    char *cancelled_text, *died_text;
    unsigned long hints;             /* that something may wait */
    pthread_t keeper;
    atomic_bool keeper_stops;
    void (*chore)(void *ctx);
    void *chore_of;
};

struct job *jobs_make(struct jobs *js, const char *id, struct account *account);
struct job **jobs_place(struct jobs *js, const char *id);
struct interest {
    struct account *account;
    struct interest *next;
};

/* -- jobs_interest.c, under the lock -- */
bool jobs_interested(const struct job *job, const struct account *account);
/* In memory only; nothing where it stands already or memory ends. */
void jobs_add_interest(struct job *job, struct account *account);
/* In memory and on disk; who waits for the job's 202 waits for it too. */
void jobs_join(struct jobs *js, struct job *job, struct account *account);
/* Takes the interest away. A job that waits goes on to the account of another. */
void jobs_withdraw(struct jobs *js, struct job *job, const struct account *account);
void jobs_free_interests(struct job *job);

/* -- jobs_shared.c, jobs_lease.c, jobs_keeper.c: see jobs_shared.h -- */
bool shared_start(struct jobs *js, char *why, size_t size);
void shared_stop(struct jobs *js);
enum submit shared_submit(struct jobs *js, struct submission *s);      /* under the lock */
struct job *shared_claim(struct jobs *js, int wake_fd);
void shared_release(struct jobs *js, struct job *job);                 /* under the lock */
void shared_let_go(struct jobs *js, struct job *job);                  /* under the lock */
enum cancel shared_cancel(struct jobs *js, const char *id, const struct account *by, struct job **out);

/* -- jobs_queue.c, under the lock -- */
void jobs_enqueue(struct jobs *js, struct job *job);
/* At the front: whose turn it was already. */
void jobs_enqueue_first(struct jobs *js, struct job *job);
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
void jobs_end(struct jobs *js, struct job *job, enum job_status status, const struct sga_error *err, char **result, size_t length);

#endif
