/* The store's parts, shared by its writer and its readers. Internal to the store. */
#ifndef SERVER_STORE_PARTS_H
#define SERVER_STORE_PARTS_H

#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>

#include "store.h"
#include "store_file.h"

enum { STORE_READERS = 4 };

enum store_op_kind { OP_INSERT, OP_STARTED, OP_REQUEUE, OP_END, OP_PROBE, OP_BARRIER, OP_TOUCH };

struct store_op {
    enum store_op_kind kind;
    struct job_row row;          /* error is borrowed */
    struct slice text;           /* request or result, borrowed */
    store_done *done;
    void *ctx;
    struct store_op *next;
};

struct store_reader {
    sqlite3 *queue, *cache;
    sqlite3_stmt *job, *request, *list, *list_one, *result;
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

    /* The writer's: used by its thread only, once it runs. */
    pthread_t thread;
    bool has_thread;
    sqlite3 *queue, *cache;
    sqlite3_stmt *insert, *started, *requeue, *end, *put;

    pthread_mutex_t lock;        /* guards the list and stop */
    pthread_cond_t work;
    struct store_op *first, **last;
    bool stop;

    pthread_mutex_t read_lock;   /* guards busy */
    pthread_cond_t read_free;
    struct store_reader reader[STORE_READERS];
};

/* -- store_evict.c: on the writer's thread -- */
bool store_evict_prepare(struct store *st);
/* The result was read at row->finished. */
bool store_evict_touch(struct store *st, const struct job_row *row);
void store_evict(struct store *st);

bool store_readers_open(struct store *st, const char *folder, char *why, size_t size);
void store_readers_close(struct store *st);
/* Columns from 0, as store_read_row reads them. */
#define STORE_ROW_COLUMNS "id, seq, status, attempts, created, started, finished, error, owner"
bool store_read_row(sqlite3_stmt *s, struct job_row *row);

#endif
