/* The durable memory of jobs and results, and who decides about them. There are two: files of
 * SQLite in the state folder (lite.c), which one daemon owns, and a database of PostgreSQL
 * (../postgres), which several daemons share. What is said here holds for both, and
 * tests/conformance/ asks both for it.
 *
 * A run of a job has an epoch, its fence: it grows with each claim, release, reaping, cancellation
 * and new submission of the job, so that what an older run says of the job counts for nothing. A
 * claim is a lease: who neither beats nor ends it in time loses it to the next one that reaps.
 *
 * The store decides: each decision is one transaction. Where one daemon owns the store, its jobs
 * table knows all that the store knows and decides before it in memory, with the same fences.
 *
 * Each request and result carries its digest: a changed result counts as none, a changed request
 * as unreadable. */
#ifndef SERVER_STORE_H
#define SERVER_STORE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "job.h"
#include "json_scan.h"

struct finished;
struct store;
struct metrics;
struct quota;

/* The files of one daemon: queue.db holds jobs (synchronous FULL: an accepted job is a promise),
 * cache.db holds results by job id (synchronous NORMAL: it may be dropped).
 *
 * Each file has one writer thread, which owns its only read-write connection, commits what has
 * gathered as one transaction, and does all checkpoints (SQLite 3.40 can lose the WAL's reset
 * between two writers). Readers are read-only. A result is committed first, then its job's end;
 * all else of the queue never waits for results, and is done in the order given.
 *
 * Locks the folder (made if missing; waiting so many seconds for another process that has it), opens or makes the files, starts the writers. A cache that
 * is damaged, older or gone is started afresh, at the start or while running. NULL with a reason
 * in why: taken, newer, corrupt, not writable. */
struct store *store_open(const char *folder, double wait, struct metrics *m, char *why, size_t size);
/* Results take at most so many bytes on disk (0: no limit); the number may change. Before
 * anything is submitted. */
void store_limit(struct store *st, const atomic_long *cache_bytes);
/* The result of this job was read: it is evicted later. */
void store_touch(struct store *st, const char *id, int64_t now);
/* Commits what is pending, stops the writer, gives the lock back. */
void store_close(struct store *st);
/* Can jobs be written? False from a failure on until a probe succeeds, and while the folder is not in its place. */
bool store_healthy(struct store *st);
/* Bytes that can be written on the disk of the state, as of the last look at its place. */
unsigned long long store_free_bytes(struct store *st);
/* Of queue.db, or of cache.db (results), each with its log. Two system calls; any thread. */
unsigned long long store_bytes(struct store *st, bool results);
/* Tries a write of as many bytes as failed before: a disk that has room again is noticed. */
void store_probe(struct store *st);
/* Looks whether the state folder is still in its place: one system call. */
void store_look(struct store *st);

/* What became of an order: nothing, as it could not be written; it is durable; or it came from
 * a run that is not the job's any more, and nothing was changed. */
enum store_kept { STORE_LOST, STORE_KEPT, STORE_FENCED };

/* Called on a thread of the store once the order is committed, or not. */
typedef void store_done(void *ctx, enum store_kept how);

/* -- Orders: they wait for nothing. Those about one job are done in the order given. --
 * Texts and structs are borrowed until done is called; done may be NULL where nothing is
 * borrowed. A false answer means that memory ended; done is not called then. */

enum store_outcome { STORE_NEW, STORE_JOINED, STORE_DONE, STORE_FULL, STORE_QUOTA };

/* Bounds of what waits; 0: none. */
struct store_room {
    int64_t queue, queue_bytes;        /* of all owners: jobs that wait, bytes of their requests */
    int64_t share;                     /* jobs of this owner that wait or run */
    int64_t jobs, bytes, seconds;      /* his quota: jobs that wait or run, bytes that wait, seconds of running in an hour */
    int64_t used;                      /* seconds that he used for what is no job */
};
struct store_submission {
    struct job_row row;                /* id, owner, created, seconds and, where the store is not shared, epoch */
    struct slice request;
    bool join;                         /* the owner is who asks: the job stands in his list */
    bool again;                        /* run it although it is done: its result is gone */
    struct store_room room;
    /* the answer */
    enum store_outcome outcome;
    const char *quota;                 /* of STORE_QUOTA: which one, in words */
    long retry;                        /* and after how many seconds to try again */
};
/* NEW: it waits, for the first time or once more. JOINED: it waits or runs already. DONE: its
 * result is there. Of two that come at once for one id, one is NEW. */
bool store_submit(struct store *st, struct store_submission *s, store_done *done, void *ctx);
/* The run of row->epoch has ended as the row says (status, started, finished, error), with its
 * result (at is NULL where there is none). Result and end are durable together or, by SQLite, the
 * result first. Said twice it is kept twice. By SQLite also for a job that waits. */
bool store_end(struct store *st, const struct job_row *row, struct slice result, store_done *done, void *ctx);
/* The run of row->epoch is given up: the job waits again, with row->attempts as its count. One
 * that was to be cancelled ends so, with row->error. *next, unless NULL: its new epoch, where the
 * store is not shared. */
bool store_release(struct store *st, const struct job_row *row, int64_t *next, store_done *done, void *ctx);

enum store_cancelled { STORE_UNKNOWN, STORE_NOT_YOURS, STORE_WITHDRAWN, STORE_CANCELLED, STORE_ASKED, STORE_ENDED };
struct store_cancel {
    const char *id, *owner;            /* owner NULL: whoever asked for it */
    const char *error;                 /* the problem of a job that is cancelled before it runs */
    int64_t now;                       /* when, for the row */
    enum store_cancelled outcome;      /* the answer */
};
/* WITHDRAWN: others want it, it goes on. CANCELLED: it waited, and has ended. ASKED: it runs, and
 * its beats are told. */
bool store_cancel(struct store *st, struct store_cancel *c, store_done *done, void *ctx);

/* Where the store is not shared: memory claimed this very job, with row->epoch. */
bool store_started(struct store *st, const struct job_row *row);
/* The owner asked for the job: it stands in his list, at the top. */
bool store_join(struct store *st, const char *id, const char *owner);
/* The same for a job that is there, where he did not before: nothing moves. */
bool store_note(struct store *st, const char *id, const char *owner);
/* What is kept; 0: no such bound. Times are milliseconds since 1970. */
struct store_keep {
    int64_t since, jobs;               /* jobs that ended before then go, and all but the latest so many that ended */
    int64_t bytes;                     /* while jobs take more, the oldest that ended go; by SQLite what queue.db takes, else bytes of requests */
    int64_t results_since, results;    /* results made before then go, and all but the latest so many */
};
/* Removes what is past a bound, a thousand rows for each at most, so that no commit waits long. */
bool store_prune(struct store *st, const struct store_keep *keep);
/* ... and does not any more. */
bool store_withdraw(struct store *st, const char *id, const char *owner);
/* A job that has ended is nobody's any more: its row and its places in lists go. */
bool store_forget(struct store *st, const char *id);
/* Only waits its turn: what was given before is committed when done is called. */
bool store_barrier(struct store *st, store_done *done, void *ctx);

/* -- Decisions that block until they are durable: on any thread, under no lock -- */

enum store_answer { STORE_FOUND, STORE_NONE, STORE_BROKEN };

struct store_claimant {
    const char *daemon;                /* its name, unlike all others */
    const char *version;               /* of the library: jobs of another one are left to its daemons while there are any */
    double lease;                      /* seconds */
    long workers;                      /* of this daemon */
    long share;                        /* percent of all workers that the jobs of one owner may hold */
};
/* The oldest job that waits of the owner who was served longest ago, with its request (malloc'ed).
 * row->epoch is that of this run. NONE: no job waits that may run. */
enum store_answer store_claim(struct store *st, const struct store_claimant *who, struct job_row *row, char **request, size_t *length);

enum store_beat_answer { BEAT_HELD, BEAT_CANCEL, BEAT_LOST };
struct store_beat {
    char id[ID_LENGTH + 1];
    int64_t epoch;
    struct job_progress progress;
    enum store_beat_answer answer;
};
/* The daemon lives and goes on with these runs: their leases begin anew. False: nobody was told. */
bool store_beat(struct store *st, const struct store_claimant *who, struct store_beat *beat, int count);
struct store_reaping {
    int tries;                         /* runs that may lose their lease */
    const char *died, *cancelled;      /* the problems of those that fail, and that were to be cancelled */
    int64_t now;                       /* when they end, for their rows */
    long count;                        /* the answer: of all that were found */
};
/* Jobs whose lease is over wait again with one more attempt; after the last one they fail. */
bool store_reap(struct store *st, struct store_reaping *r);
/* Tells the other daemons that something changed. A hint: who misses it looks by himself. */
void store_hint(struct store *st);
/* Until a hint comes, at most so many seconds. */
void store_listen(struct store *st, double seconds);
/* Do several daemons share it? Then the store decides, and each daemon's memory only follows. */
bool store_shared(const struct store *st);
/* The row as it is, without its error, and how far it is. */
enum store_answer store_look_at(struct store *st, const char *id, struct job_row *row, struct job_progress *progress);
/* Where the store is not shared: an epoch above all that were given, in this life or before. */
int64_t store_epoch(struct store *st);


/* Reads, on any thread. Texts are malloc'ed, but results, which are of spool_new; row->error too. */
enum store_answer store_job(struct store *st, const char *id, struct job_row *row);
enum store_answer store_request(struct store *st, const char *id, char **text, size_t *length);
enum store_answer store_result(struct store *st, const char *id, char **text, size_t *length);
/* The end of a job whose row was read, with its result or, where it is not done, its request. BROKEN where memory ends, too. */
enum store_answer store_finished(struct store *st, const char *id, const struct job_row *row, struct finished **out);

/* Tells each owner that asked for the job; false where that cannot be read. */
bool store_owners(struct store *st, const char *id, void (*each)(void *ctx, const char *owner), void *ctx);
enum store_answer store_owned(struct store *st, const char *id, const char *owner);
/* Milliseconds that each owner's jobs ran since then. Reads all rows: at the start only. */
bool store_used(struct store *st, int64_t since, void (*each)(void *ctx, const char *owner, int64_t ms), void *ctx);

struct store_page {
    struct job_row *row;      /* newest first */
    int rows;
    bool more;                /* there are older ones */
};
struct store_query {
    int64_t before;           /* only jobs whose seq is smaller; 0: all. Each list has a seq of its own */
    unsigned statuses;        /* bit set of those that count */
    int limit;                /* rows of the page */
    const char *owner;        /* only jobs that this one asked for; NULL: all */
};
/* Costs what it gives, however many jobs there are: each list and each status has an index. */
enum store_answer store_list(struct store *st, const struct store_query *q, struct store_page *page);
void store_page_free(struct store_page *page);

/* Once, before anything is submitted, where the store is not shared: jobs that were running go back
 * to the queue with one more attempt; then each queued job is told, oldest first. */
bool store_recover(struct store *st, void (*each)(void *ctx, const struct job_row *row), void *ctx, char *why, size_t size);

#endif
