/* The jobs that have not ended, or whose end is not on disk yet: a table by id, a bounded
 * queue, and those who wait. One lock guards all of it; it is held for moments only.
 *
 * A job is a wait point: an HTTP request whose connection is suspended stands in its list
 * and is resumed once what it waits for has come, its deadline has passed, or the service
 * closes. Who suspends and resumes is given as hooks, so that nothing here knows HTTP.
 *
 *   queued -> running -> done | failed | cancelled      (ended: its text is made, never changes)
 *
 * Order on disk: the row, its start, its result, its end. The 202 waits for the row, whoever is
 * told of an end for the end; one whose row could not be written ends for those who wait only.
 * Ends that wait for the disk take memory: past the setting unsaved-memory no job is started. */
#ifndef SERVER_JOBS_H
#define SERVER_JOBS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "job.h"

struct account;
struct config;
struct finished;
struct job;
struct jobs;
struct memory_cache;
struct metrics;
struct quota;
struct sga_buf;
struct sga_error;
struct store;
struct waiter;

struct jobs_hooks {
    void (*suspend)(void *connection);
    void (*resume)(void *connection);
    bool (*left)(void *connection);         /* of one that is suspended: its client hung up */
};

struct jobs *jobs_new(const struct config *c, struct store *st, struct memory_cache *memory_cache, struct metrics *m, struct jobs_hooks hooks);
/* Takes over what the store holds from before; where daemons share the store, begins to follow it.
 * Before workers start. */
bool jobs_recover(struct jobs *js, char *why, size_t size);
void jobs_free(struct jobs *js);

/* The account of this name, made where there is none, with its quota set anew. It lives as
 * long as the table. NULL: no memory. "" is that of requests without a token. */
struct account *jobs_account(struct jobs *js, const char *name, const struct quota *quota);

/* The same, but one that is there keeps its quota. */
struct account *jobs_account_of(struct jobs *js, const char *name, const struct quota *quota);
/* The account used the machine for so long, for something that is no job. */
void jobs_charge(struct jobs *js, struct account *account, double seconds);

/* -- Asking -- */

enum submit { SUBMIT_NEW, SUBMIT_JOINED, SUBMIT_DONE, SUBMIT_FULL, SUBMIT_QUOTA, SUBMIT_DRAINING, SUBMIT_NO_MEMORY };

struct submission {
    const char *id;
    char *request;                  /* canonical, malloc'ed; taken over and set to NULL by SUBMIT_NEW */
    size_t length;
    struct account *account;
    const char *owner;              /* whose job it is; NULL: the account's */
    const char *request_id, *traceparent;   /* for the log */
    bool again;                     /* although it is done: its result is gone */
    /* the answer */
    struct job *job;                /* a reference, of SUBMIT_NEW and SUBMIT_JOINED */
    struct finished *finished;      /* a reference, of SUBMIT_DONE */
    const char *quota;              /* of SUBMIT_QUOTA: which one, in words */
    long retry;                     /* and after how many seconds to try again */
};
/* A request that was found good. It becomes a job unless the same one is alive; one that
 * failed or was cancelled is run again. */
enum submit jobs_submit(struct jobs *js, struct submission *s);

/* The account asked for a job that is done: it stands in its list. Costs a write the first time
 * only, and waits for none. */
void jobs_note(struct jobs *js, const char *id, const struct account *account);
/* ... and does not want it there any more; on disk once a barrier after it is. */
void jobs_drop_interest(struct jobs *js, const char *id, const struct account *account);
/* Did the account ask for this job, which has not ended? */
bool jobs_asked(struct jobs *js, const char *id, const struct account *account);
/* Those who asked for the job before, as the store knows them. */
void jobs_load_interests(struct jobs *js, struct job *job);

/* Where daemons share the store: a job that it has, as followed from now on, with a reference. NULL: no memory. */
struct job *jobs_watch(struct jobs *js, const struct job_row *row);
/* Looks at the store's row of a followed job: its state and its end become this one's. */
void jobs_refresh(struct jobs *js, struct job *job);
/* Where daemons share the store: done once a second or so, on a thread that may wait. NULL: nothing any more. */
void jobs_chore(struct jobs *js, void (*chore)(void *ctx), void *ctx);

/* A living job with a reference, or NULL. */
struct job *jobs_find(struct jobs *js, const char *id);
void job_ref(struct job *job);
void job_unref(struct job *job);          /* NULL is allowed */

struct job_look {
    struct job_row row;                   /* without error */
    struct job_progress progress;
    uint64_t event;                       /* grows with each change */
    struct finished *finished;            /* a reference, once it has ended */
    int stored;                           /* 1: its row is on disk; -1: that failed; 0: not yet */
    bool gone;                            /* the store does not have it: it took it not, or not any more */
    enum submit refused;                  /* where it took it not: SUBMIT_FULL or SUBMIT_QUOTA, as in struct submission */
    const char *quota;
    long retry;
};
void jobs_look(struct jobs *js, struct job *job, struct job_look *look);

enum cancel { CANCEL_BROKEN, CANCEL_ENDED_NOW, CANCEL_ASKED, CANCEL_WITHDRAWN, CANCEL_TOO_LATE, CANCEL_UNKNOWN, CANCEL_NOT_YOURS };
/* Withdraws the interest of the account `by`, where others have one too; else ends a queued job,
 * asks a running one to stop. NULL may cancel the jobs of all. *job gets a reference unless it is
 * unknown or another's. */
enum cancel jobs_cancel(struct jobs *js, const char *id, const struct account *by, struct job **job);

/* -- Waiting -- */

/* True: the connection was suspended and will be resumed, once. False: there is no need
 * to wait (any more), or no room: go on with what jobs_look says. The caller holds a
 * reference to the job meanwhile. */
bool jobs_wait(struct jobs *js, struct job *job, struct waiter *w);
/* An event stream's place among all and in its account's quota: from before its first byte until
 * jobs_stream_end, also between two of its waits, so that who holds it never loses it to another. */
enum stream_room { STREAM_TAKEN, STREAMS_FULL, STREAM_QUOTA };
enum stream_room jobs_stream_begin(struct jobs *js, struct account *account);
void jobs_stream_end(struct jobs *js, struct account *account);
/* A job-like wait point that counts as stored once all that was written before is. */
struct job *jobs_barrier(struct jobs *js);
/* Resumes whose deadline has passed. */
void jobs_tick(struct jobs *js, double now);

/* -- Running: for workers -- */

/* Blocks for the next job; NULL once the service drains. wake_fd is an eventfd that is
 * written to when the job is to be cancelled or the service stops. */
struct job *jobs_claim(struct jobs *js, int wake_fd);
/* The canonical request; read from the store where it is not in memory. NULL: lost. */
const char *jobs_request(struct jobs *js, struct job *job, size_t *length);
/* How long the canonical request may run: its own limit, within the service's. */
double jobs_seconds(const struct config *c, const char *request, size_t length);
const char *job_id(const struct job *job);
const struct account *job_account(const struct job *job);       /* on which it runs; fixed */
bool jobs_cancelled(struct jobs *js, struct job *job);
/* Another daemon has the job now: true once, and then it is not the worker's any more. */
bool jobs_lost(struct jobs *js, struct job *job);
void jobs_progress(struct jobs *js, struct job *job, const char *stage, double fraction, double t);
/* The end: the result's text, of spool_new, which is taken over (*result becomes NULL; where memory ends it stays the caller's), or err. */
void jobs_done(struct jobs *js, struct job *job, char **result, size_t length);
void jobs_failed(struct jobs *js, struct job *job, const struct sga_error *err);
/* Back to the front of its queue, here and on disk, as if it had not been taken. One that was
 * cancelled meanwhile ends. */
void jobs_requeue(struct jobs *js, struct job *job);
/* The same for a job whose process was killed, which counts as an attempt: once. False: it was
 * done before, and the job is the caller's to end. */
bool jobs_try_again(struct jobs *js, struct job *job);
/* A worker has nothing to do, so that a job that runs may have a process more: until jobs_helped. False: there is none. */
bool jobs_help(struct jobs *js);
/* Its place is wanted by a worker. */
bool jobs_help_over(struct jobs *js);
/* The process is gone, after so many seconds, which its account used. */
void jobs_helped(struct jobs *js, const struct job *job, double seconds);
/* A worker tells that no child can be started for it (any more, or again). */
void jobs_worker_unable(struct jobs *js, bool unable);

/* For /metrics, of the accounts that have a name: 100 at most, the others together as "other". */
void jobs_write_accounts(struct jobs *js, struct sga_buf *out);

/* -- Ending -- */

void jobs_drain(struct jobs *js);               /* no new jobs, no claims */
void jobs_leave(struct jobs *js);               /* no claims: another process will run what is accepted */
bool jobs_resting(struct jobs *js);             /* no claims any more, for whichever reason */
void jobs_leave_waiters(struct jobs *js);       /* who waits for more than the disk does so no longer */
bool jobs_draining(struct jobs *js);
void jobs_close_waiters(struct jobs *js);       /* resumes all; nobody may wait from now on */
void jobs_stop_running(struct jobs *js);        /* workers give their jobs back */
bool jobs_stopping(struct jobs *js);

struct jobs_counts {
    unsigned long queued, running, queue_bytes, waiters, streams;
    unsigned long ending, ending_bytes;       /* whose end is on its way to the disk */
    double oldest;            /* seconds since the job that waits longest was accepted; 0: none waits */
    bool full;                /* the queue is */
    bool idle;                /* no worker can run anything */
};
void jobs_count(struct jobs *js, struct jobs_counts *out);

#endif
