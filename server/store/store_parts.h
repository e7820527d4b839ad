/* The store's parts, shared by its writer and its readers. Internal to the store. */
#ifndef SERVER_STORE_PARTS_H
#define SERVER_STORE_PARTS_H

#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>

#include "store_ops.h"
#include "store_file.h"
#include "store_pieces.h"
#include "store_place.h"

enum { STORE_READERS = 4 };

enum store_op_kind { OP_SUBMIT, OP_STARTED, OP_RELEASE, OP_END, OP_CANCEL, OP_CLAIM, OP_BEAT, OP_REAP, OP_PROBE, OP_BARRIER, OP_TOUCH, OP_JOIN, OP_NOTE,
                     OP_WITHDRAW, OP_FORGET, OP_PRUNE, OP_PRUNE_RESULTS };

struct store_op {
    enum store_op_kind kind;
    struct job_row row;          /* error is borrowed */
    struct slice text;           /* request or result, borrowed */
    int64_t anew;                /* epoch of a job that waits again */
    struct store_keep keep;      /* of what is pruned */
    void *what;                  /* that is decided: by kind */
    enum store_kept how;         /* what came of it, unless the commit fails */
    store_done *done;
    void *ctx;
    struct store_op *next;
};

/* Of results alone: the queue's thread does not see it. */
static inline bool store_op_of_cache(const struct store_op *op) { return op->kind == OP_TOUCH || op->kind == OP_PRUNE_RESULTS; }

/* A thread that owns the read-write connection to one file and commits what has gathered. */
struct store_writer {
    struct lite *store;
    void (*commit)(struct lite *st, struct store_op *ops);    /* takes over the list */
    pthread_t thread;
    bool runs;
    pthread_mutex_t lock;        /* guards what follows */
    pthread_cond_t work;
    struct store_op *first, **last;
    atomic_ulong count;          /* of the list; may be read without the lock */
    bool stop;
};

struct store_reader {
    sqlite3 *queue, *cache;
    sqlite3_stmt *job, *request, *list, *list_one, *mine, *mine_one, *owners, *owned, *result, *pieces;
    unsigned cache_age;          /* of the cache file that is open */
    bool busy;
};

struct lite {
    struct store face;
    int lock_fd;
    char *folder;
    struct metrics *metrics;
    const atomic_long *cache_limit;   /* bytes; NULL or 0: none */
    atomic_bool healthy;
    atomic_bool cache_broken;    /* a reader found it so: the writer starts it afresh */
    atomic_uint cache_age;       /* grows with each fresh cache file */
    atomic_uint cache_failures;  /* times in a row that no result could be written */

    /* Of the thread that writes the queue, once it runs. */
    struct store_writer queue_writer;
    sqlite3 *queue;
    sqlite3_stmt *known, *insert, *started, *release, *end, *ended, *join, *note, *withdraw, *forget, *prune_age, *prune_count, *prune_bytes;
    atomic_size_t needed;        /* bytes that could not be written; a probe must write as many */
    struct store_place place;    /* of the queue file */
    atomic_bool moved;           /* it is not there any more */
    atomic_ullong free_bytes;    /* on its disk */

    atomic_llong epoch;          /* the last that was given; each life of the store has a range of its own */
    bool life_unsaved;           /* the queue file does not know of this life yet */

    /* Of the thread that writes the results. */
    struct store_writer cache_writer;
    sqlite3 *cache;
    sqlite3_stmt *make_way, *put;
    bool cache_full;             /* the latest write found no room on the disk */

    pthread_mutex_t read_lock;   /* guards busy */
    pthread_cond_t read_free;
    struct store_reader reader[STORE_READERS];
};

static inline struct lite *lite_of(struct store *face) { return (struct lite *)face; }

/* -- lite.c -- */
bool lite_submit(struct lite *st, struct store_op op);
/* Writes down which epochs this life gives. */
bool lite_save_life(struct lite *st);

/* -- store_writer.c -- */
bool store_writer_start(struct store_writer *w, struct lite *st, void (*commit)(struct lite *, struct store_op *));
/* Commits what is left, ends the thread. */
void store_writer_stop(struct store_writer *w);
/* Takes over the operations of the list. */
void store_writer_give(struct store_writer *w, struct store_op *ops);
bool store_step(sqlite3_stmt *s);            /* true where it is done; reset in any case */
bool store_exec(sqlite3 *db, const char *sql);
void store_bind_text(sqlite3_stmt *s, int at, const char *text);    /* NULL is allowed */
void store_bind_sum(sqlite3_stmt *s, int at, const char *id, struct slice text);

/* -- store_queue.c: on the queue's thread, but for the first -- */
bool store_queue_prepare(struct lite *st, char *why, size_t size);
void store_queue_commit(struct lite *st, struct store_op *ops);

/* -- store_decide.c: on the queue's thread, but for those that wait for it -- */
bool lite_decide_submit(struct lite *st, struct store_op *op);
bool lite_decide_cancel(struct lite *st, struct store_op *op);
bool lite_decide_claim(struct lite *st, struct store_op *op);
bool lite_decide_beat(struct lite *st, struct store_op *op);
bool lite_decide_reap(struct lite *st, struct store_op *op);
enum store_answer lite_claim(struct store *face, const struct store_claimant *who, struct job_row *row, char **request, size_t *length);
bool lite_beat(struct store *face, const struct store_claimant *who, struct store_beat *beat, int count);
bool lite_reap(struct store *face, struct store_reaping *r);

/* -- store_cache.c: on the results' thread, but for the first -- */
bool store_cache_prepare(struct lite *st, char *why, size_t size);
/* Results first, then what belongs to the queue goes on to its thread: a job that is marked done
 * has its result, whenever the power fails. */
void store_cache_commit(struct lite *st, struct store_op *ops);

/* -- store_evict.c: on the results' thread -- */
bool store_evict_prepare(struct lite *st);
/* The result was read at row->finished. */
bool store_evict_touch(struct lite *st, const struct job_row *row);
/* By age and number. */
void store_evict_kept(struct lite *st, const struct store_keep *keep);
/* What its tables take, without pages that are free; -1: it cannot be read. */
int64_t store_bytes_used(sqlite3 *db);
/* After so many bytes were written: keeps results within the limit, and the disk's spare free. */
void store_evict(struct lite *st, int64_t bytes);
/* A write of so many bytes found no room on the disk: did older results give any? */
bool store_evict_for(struct lite *st, int64_t bytes);

/* -- store_list.c -- */
enum store_answer lite_list(struct store *face, const struct store_query *q, struct store_page *page);
bool lite_owners(struct store *face, const char *id, void (*each)(void *ctx, const char *owner), void *ctx);
enum store_answer lite_owned(struct store *face, const char *id, const char *owner);
bool lite_used(struct store *face, int64_t since, void (*each)(void *ctx, const char *owner, int64_t ms), void *ctx);
bool store_list_prepare(struct store_reader *r, char *why, size_t size);

/* -- store_verdict.c: of a job that is done, where its result is stored; else it stays "" -- */
void store_read_verdict(struct store_reader *r, struct job_row *row);

/* -- store_read.c -- */
enum store_answer lite_job(struct store *face, const char *id, struct job_row *row);
enum store_answer lite_request(struct store *face, const char *id, char **text, size_t *length);
enum store_answer lite_result(struct store *face, const char *id, char **text, size_t *length);
enum store_answer lite_look_at(struct store *face, const char *id, struct job_row *row, struct job_progress *progress);
struct store_reader *store_borrow(struct lite *st);
void store_give_back(struct lite *st, struct store_reader *r);
bool store_readers_open(struct lite *st, const char *folder, char *why, size_t size);
void store_readers_close(struct lite *st);
/* Columns from 0, as store_read_row reads them. */
#define STORE_ROW_COLUMNS "id, seq, status, attempts, created, started, finished, error, owner, seconds, epoch"
bool store_read_row(sqlite3_stmt *s, struct job_row *row);

#endif
