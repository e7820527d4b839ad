/* The durable memory: queue.db holds jobs (synchronous FULL: an accepted job is a promise),
 * cache.db holds results by job id (synchronous NORMAL: it may be dropped).
 *
 * Each file has one writer thread, which owns its only read-write connection, commits what has
 * gathered as one transaction, and does all checkpoints (SQLite 3.40 can lose the WAL's reset
 * between two writers). Readers are read-only. A result is committed first, then its job's end;
 * all else of the queue never waits for results, and is done in the order given.
 *
 * A queue that is damaged or newer is refused at the start. A cache that is damaged, older
 * or gone is started afresh, at the start or while running. Each request and result carries
 * its digest: a changed result counts as none, a changed request as unreadable. */
#ifndef SERVER_STORE_H
#define SERVER_STORE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "job.h"
#include "json_scan.h"

struct store;
struct metrics;

/* Locks the folder (made if missing; waiting so many seconds for another process that has it), opens or makes the files, starts the writer.
 * NULL with a reason in why: taken, newer, corrupt, not writable. */
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

/* Called on the queue's thread once the write is committed (ok) or lost (not ok). */
typedef void store_done(void *ctx, bool ok);

/* Texts are borrowed until done is called; done may be NULL where nothing is borrowed.
 * A false answer means that memory ended; done is not called then. */
bool store_insert(struct store *st, const struct job_row *row, const char *request, size_t length, store_done *done, void *ctx);
bool store_started(struct store *st, const struct job_row *row);
bool store_requeue(struct store *st, const struct job_row *row);
/* The end of a job with its result (at is NULL where there is none) and row->error. */
bool store_end(struct store *st, const struct job_row *row, struct slice result, store_done *done, void *ctx);
/* The owner asked for the job: it stands in his list, at the top. Before the job is inserted, or later. */
bool store_join(struct store *st, const char *id, const char *owner);
/* The same for a job that is there, where he did not before: nothing moves. */
bool store_note(struct store *st, const char *id, const char *owner);
/* Removes jobs that ended before then (0: none), and those beyond the latest `keep` (0: none), a
 * thousand of each at most, so that no commit waits long. */
bool store_prune(struct store *st, int64_t before, int64_t keep);
/* ... and does not any more. */
bool store_withdraw(struct store *st, const char *id, const char *owner);
/* A job that has ended is nobody's any more: its row and its places in lists go. */
bool store_forget(struct store *st, const char *id);
/* Only waits its turn: what was given before is committed when done is called. */
bool store_barrier(struct store *st, store_done *done, void *ctx);

enum store_answer { STORE_FOUND, STORE_NONE, STORE_BROKEN };

/* Reads, on any thread. Texts are malloc'ed; row->error too. */
enum store_answer store_job(struct store *st, const char *id, struct job_row *row);
enum store_answer store_request(struct store *st, const char *id, char **text, size_t *length);
enum store_answer store_result(struct store *st, const char *id, char **text, size_t *length);

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

/* Once, before anything is submitted: jobs that were running go back to the queue with one
 * more attempt; then each queued job is told, oldest first. */
bool store_recover(struct store *st, void (*each)(void *ctx, const struct job_row *row), void *ctx, char *why, size_t size);

#endif
