/* The store's parts, shared by its writer and its readers. Internal to the store. */
#ifndef SERVER_STORE_PARTS_H
#define SERVER_STORE_PARTS_H

#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>

#include "store.h"
#include "store_file.h"
#include "store_place.h"

enum { STORE_READERS = 4 };

enum store_op_kind { OP_INSERT, OP_STARTED, OP_REQUEUE, OP_END, OP_PROBE, OP_BARRIER, OP_TOUCH, OP_JOIN, OP_NOTE, OP_WITHDRAW, OP_FORGET, OP_PRUNE };

struct store_op {
    enum store_op_kind kind;
    struct job_row row;          /* error is borrowed */
    struct slice text;           /* request or result, borrowed */
    store_done *done;
    void *ctx;
    struct store_op *next;
};

/* A thread that owns the read-write connection to one file and commits what has gathered. */
struct store_writer {
    struct store *store;
    void (*commit)(struct store *st, struct store_op *ops);    /* takes over the list */
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
    sqlite3_stmt *job, *request, *list, *list_one, *mine, *mine_one, *owners, *owned, *result;
    unsigned cache_age;          /* of the cache file that is open */
    bool busy;
};

struct store {
    int lock_fd;
    char *folder;
    struct metrics *metrics;
    const atomic_long *cache_limit;   /* bytes; NULL or 0: none */
    atomic_bool healthy;
    atomic_bool cache_broken;    /* a reader found it so: the writer starts it afresh */
    atomic_uint cache_age;       /* grows with each fresh cache file */

    /* Of the thread that writes the queue, once it runs. */
    struct store_writer queue_writer;
    sqlite3 *queue;
    sqlite3_stmt *insert, *started, *requeue, *end, *join, *note, *withdraw, *forget, *prune_age, *prune_count;
    atomic_size_t needed;        /* bytes that could not be written; a probe must write as many */
    struct store_place place;    /* of the queue file */
    atomic_bool moved;           /* it is not there any more */
    atomic_ullong free_bytes;    /* on its disk */

    /* Of the thread that writes the results. */
    struct store_writer cache_writer;
    sqlite3 *cache;
    sqlite3_stmt *put;

    pthread_mutex_t read_lock;   /* guards busy */
    pthread_cond_t read_free;
    struct store_reader reader[STORE_READERS];
};

/* -- store_writer.c -- */
bool store_writer_start(struct store_writer *w, struct store *st, void (*commit)(struct store *, struct store_op *));
/* Commits what is left, ends the thread. */
void store_writer_stop(struct store_writer *w);
/* Takes over the operations of the list. */
void store_writer_give(struct store_writer *w, struct store_op *ops);
bool store_step(sqlite3_stmt *s);            /* true where it is done; reset in any case */
bool store_exec(sqlite3 *db, const char *sql);
void store_bind_text(sqlite3_stmt *s, int at, const char *text);    /* NULL is allowed */
void store_bind_sum(sqlite3_stmt *s, int at, const char *id, struct slice text);

/* -- store_queue.c: on the queue's thread, but for the first -- */
bool store_queue_prepare(struct store *st, char *why, size_t size);
void store_queue_commit(struct store *st, struct store_op *ops);

/* -- store_cache.c: on the results' thread, but for the first -- */
bool store_cache_prepare(struct store *st, char *why, size_t size);
/* Results first, then what belongs to the queue goes on to its thread: a job that is marked done
 * has its result, whenever the power fails. */
void store_cache_commit(struct store *st, struct store_op *ops);

/* -- store_evict.c: on the results' thread -- */
bool store_evict_prepare(struct store *st);
/* The result was read at row->finished. */
bool store_evict_touch(struct store *st, const struct job_row *row);
void store_evict(struct store *st);

/* -- store_list.c -- */
bool store_list_prepare(struct store_reader *r, char *why, size_t size);

/* -- store_verdict.c: of a job that is done, where its result is stored; else it stays "" -- */
void store_read_verdict(struct store_reader *r, struct job_row *row);

/* -- store_read.c -- */
struct store_reader *store_borrow(struct store *st);
void store_give_back(struct store *st, struct store_reader *r);
bool store_readers_open(struct store *st, const char *folder, char *why, size_t size);
void store_readers_close(struct store *st);
/* Columns from 0, as store_read_row reads them. */
#define STORE_ROW_COLUMNS "id, seq, status, attempts, created, started, finished, error, owner, seconds"
bool store_read_row(sqlite3_stmt *s, struct job_row *row);

#endif
