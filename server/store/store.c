/* The store's life, and what its callers give to its writers. */
#include "store_parts.h"
#include "log.h"
#include "metrics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TOUCHES = 4096 };      /* that may wait: more are not worth their memory */

/* Ends with a result come to the queue's thread by way of the results'. */
static struct store_writer *writer_of(struct store *st, const struct store_op *op)
{
    return op->kind == OP_TOUCH || (op->kind == OP_END && op->text.at) ? &st->cache_writer : &st->queue_writer;
}

static bool submit(struct store *st, enum store_op_kind kind, const struct job_row *row, struct slice text, store_done *done, void *ctx)
{
    struct store_op *op = calloc(1, sizeof *op);
    if (!op)
        return false;
    *op = (struct store_op){ .kind = kind, .text = text, .done = done, .ctx = ctx };
    if (row)
        op->row = *row;
    store_writer_give(writer_of(st, op), op);
    return true;
}

static const struct slice nothing = { NULL, 0 };

void store_limit(struct store *st, const atomic_long *cache_bytes)
{
    st->cache_limit = cache_bytes;
}

void store_touch(struct store *st, const char *id, int64_t now)
{
    struct job_row row = { .finished = now };
    snprintf(row.id, sizeof row.id, "%s", id);
    if (st->cache_writer.count < TOUCHES)      /* a hint: read without the lock */
        submit(st, OP_TOUCH, &row, nothing, NULL, NULL);
}

bool store_insert(struct store *st, const struct job_row *row, const char *request, size_t length, store_done *done, void *ctx)
{
    return submit(st, OP_INSERT, row, (struct slice){ request, length }, done, ctx);
}

bool store_started(struct store *st, const struct job_row *row)
{
    return submit(st, OP_STARTED, row, nothing, NULL, NULL);
}

bool store_requeue(struct store *st, const struct job_row *row)
{
    return submit(st, OP_REQUEUE, row, nothing, NULL, NULL);
}

bool store_end(struct store *st, const struct job_row *row, struct slice result, store_done *done, void *ctx)
{
    return submit(st, OP_END, row, result, done, ctx);
}

static bool submit_interest(struct store *st, enum store_op_kind kind, const char *id, const char *owner)
{
    struct job_row row = { .seq = 0 };
    snprintf(row.id, sizeof row.id, "%s", id);
    snprintf(row.owner, sizeof row.owner, "%s", owner);
    return submit(st, kind, &row, nothing, NULL, NULL);
}

bool store_join(struct store *st, const char *id, const char *owner)
{
    return submit_interest(st, OP_JOIN, id, owner);
}

bool store_note(struct store *st, const char *id, const char *owner)
{
    return submit_interest(st, OP_NOTE, id, owner);
}

bool store_prune(struct store *st, int64_t before, int64_t keep)
{
    struct job_row row = { .finished = before, .seq = keep };
    return submit(st, OP_PRUNE, &row, nothing, NULL, NULL);
}

bool store_withdraw(struct store *st, const char *id, const char *owner)
{
    return submit_interest(st, OP_WITHDRAW, id, owner);
}

bool store_forget(struct store *st, const char *id)
{
    return submit_interest(st, OP_FORGET, id, "");
}

bool store_barrier(struct store *st, store_done *done, void *ctx)
{
    return submit(st, OP_BARRIER, NULL, nothing, done, ctx);
}

void store_probe(struct store *st)
{
    submit(st, OP_PROBE, NULL, nothing, NULL, NULL);
}

bool store_healthy(struct store *st)
{
    return atomic_load(&st->healthy) && !atomic_load(&st->moved);
}

unsigned long long store_free_bytes(struct store *st)
{
    return atomic_load(&st->free_bytes);
}

unsigned long long store_bytes(struct store *st, bool results)
{
    return store_place_bytes(st->folder, results ? "cache.db" : "queue.db");
}

void store_look(struct store *st)
{
    struct store_place now;
    bool moved = !store_place_of(st->folder, &now) || !store_place_same(&now, &st->place);
    if (moved != atomic_exchange(&st->moved, moved))
        log_event(LOG_L_ERROR, moved ? "state_folder_gone" : "state_folder_back", "state", st->folder, NULL);
    atomic_store(&st->free_bytes, store_place_free(st->folder));
}

/* Everything but the thread. */
static bool open_parts(struct store *st, const char *folder, double wait, char *why, size_t size)
{
    return (st->folder = strdup(folder)) && (st->lock_fd = store_file_lock(folder, wait, why, size)) >= 0
        && store_place_sound(folder, why, size)
        && (st->queue = store_file_open(folder, FILE_QUEUE, true, why, size))
        && store_place_of(folder, &st->place) && store_place_mark(folder, why, size)
        && (atomic_store(&st->free_bytes, store_place_free(folder)), true)
        && (st->cache = store_file_open(folder, FILE_CACHE, true, why, size))
        && store_queue_prepare(st, why, size) && store_cache_prepare(st, why, size)
        && store_readers_open(st, folder, why, size);
}

struct store *store_open(const char *folder, double wait, struct metrics *m, char *why, size_t size)
{
    struct store *st = calloc(1, sizeof *st);
    if (!st) {
        snprintf(why, size, "out of memory");
        return NULL;
    }
    st->lock_fd = -1;
    st->metrics = m;
    atomic_init(&st->healthy, true);
    pthread_mutex_init(&st->read_lock, NULL);
    pthread_cond_init(&st->read_free, NULL);
    if (open_parts(st, folder, wait, why, size) && store_writer_start(&st->queue_writer, st, store_queue_commit)
        && store_writer_start(&st->cache_writer, st, store_cache_commit))
        return st;
    store_close(st);
    return NULL;
}

void store_close(struct store *st)
{
    if (!st)
        return;
    store_writer_stop(&st->cache_writer);      /* first: it gives to the other */
    store_writer_stop(&st->queue_writer);
    store_readers_close(st);
    sqlite3_stmt *const statements[] = { st->insert, st->started, st->requeue, st->end, st->join, st->note, st->withdraw, st->forget,
                                         st->prune_age, st->prune_count, st->put };
    for (size_t i = 0; i < sizeof statements / sizeof *statements; i++)
        sqlite3_finalize(statements[i]);
    sqlite3_close(st->cache);
    sqlite3_close(st->queue);
    if (st->lock_fd >= 0)
        close(st->lock_fd);
    free(st->folder);
    free(st);
}

/* On a disk that is full the rows stay as they are: the jobs run all the same, and their starts
 * are written with the attempts that are counted here. */
static void take_back(struct store *st)
{
    if (store_exec(st->queue, "UPDATE jobs SET attempts = attempts + 1, status = 0, started = 0 WHERE status = 1"))
        return;
    log_event(LOG_L_ERROR, "queue_write_failed", "reason", sqlite3_errmsg(st->queue), NULL);
    atomic_store(&st->healthy, false);
}

/* The writer's connection is used here from another thread, which is safe since nothing has
 * been submitted yet; the walk has a reader's, because what is told may submit. */
bool store_recover(struct store *st, void (*each)(void *ctx, const struct job_row *row), void *ctx, char *why, size_t size)
{
    take_back(st);
    sqlite3_stmt *s = store_file_prepare(st->reader[0].queue, "SELECT " STORE_ROW_COLUMNS " FROM jobs WHERE status IN (0, 1) ORDER BY seq", why, size);
    if (!s)
        return false;
    int rc;
    while ((rc = sqlite3_step(s)) == SQLITE_ROW) {
        struct job_row row;
        bool whole = store_read_row(s, &row);
        row.attempts += row.status == JOB_RUNNING;
        row.status = JOB_QUEUED;
        row.started = 0;
        if (whole)
            each(ctx, &row);
        else
            log_event(LOG_L_ERROR, "job_row_damaged", NULL);
        free(row.error);
    }
    if (rc != SQLITE_DONE)
        snprintf(why, size, "the queue cannot be read: %s", sqlite3_errstr(rc));
    sqlite3_finalize(s);
    return rc == SQLITE_DONE;
}
