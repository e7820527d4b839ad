/* The store's life and its writer. */
#include "store_parts.h"
#include "log.h"
#include "metrics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void bind_text(sqlite3_stmt *s, int at, const char *text)
{
    if (text)
        sqlite3_bind_text(s, at, text, -1, SQLITE_STATIC);
    else
        sqlite3_bind_null(s, at);
}

static void bind_sum(sqlite3_stmt *s, int at, const char *id, struct slice text)
{
    unsigned char sum[DIGEST_BYTES];
    digest_kept(sum, id, text.at, text.len);
    sqlite3_bind_blob(s, at, sum, sizeof sum, SQLITE_TRANSIENT);
}

static bool step(sqlite3_stmt *s)
{
    int rc = sqlite3_step(s);
    sqlite3_reset(s);
    sqlite3_clear_bindings(s);
    return rc == SQLITE_DONE;
}

static bool exec(sqlite3 *db, const char *sql)
{
    return sqlite3_exec(db, sql, NULL, NULL, NULL) == SQLITE_OK;
}

static bool apply(struct store *st, const struct store_op *op)
{
    const struct job_row *r = &op->row;
    sqlite3_stmt *s;
    switch (op->kind) {
    case OP_INSERT:
        s = st->insert;
        bind_text(s, 1, r->id);
        sqlite3_bind_int(s, 2, r->status);
        sqlite3_bind_int64(s, 3, r->created);
        sqlite3_bind_blob64(s, 4, op->text.at, op->text.len, SQLITE_STATIC);
        bind_sum(s, 5, r->id, op->text);
        bind_text(s, 6, r->owner);
        return step(s);
    case OP_STARTED:
        s = st->started;
        bind_text(s, 1, r->id);
        sqlite3_bind_int64(s, 2, r->started);
        return step(s);
    case OP_REQUEUE:
        s = st->requeue;
        bind_text(s, 1, r->id);
        return step(s);
    case OP_END:
        s = st->end;
        bind_text(s, 1, r->id);
        sqlite3_bind_int(s, 2, r->status);
        sqlite3_bind_int64(s, 3, r->started);
        sqlite3_bind_int64(s, 4, r->finished);
        bind_text(s, 5, r->error);
        return step(s);
    case OP_PROBE:
        return store_file_touch(st->queue);
    default:
        return true;
    }
}

/* Results first: a job that is marked done has its result, whenever the power fails. */
static bool put_results(struct store *st, const struct store_op *ops)
{
    bool any = false, ok = true;
    for (const struct store_op *op = ops; op; op = op->next)
        any |= op->kind == OP_END && op->text.at;
    if (!any)
        return true;
    ok = exec(st->cache, "BEGIN IMMEDIATE");
    for (const struct store_op *op = ops; ok && op; op = op->next) {
        if (op->kind != OP_END || !op->text.at)
            continue;
        bind_text(st->put, 1, op->row.id);
        sqlite3_bind_int64(st->put, 2, op->row.finished);
        sqlite3_bind_blob64(st->put, 3, op->text.at, op->text.len, SQLITE_STATIC);
        bind_sum(st->put, 4, op->row.id, op->text);
        ok = step(st->put);
    }
    if (ok && exec(st->cache, "COMMIT"))
        return true;
    if (store_file_broken(sqlite3_errcode(st->cache)))
        atomic_store(&st->cache_broken, true);
    log_event(LOG_L_ERROR, "cache_write_failed", "reason", sqlite3_errmsg(st->cache), NULL);
    exec(st->cache, "ROLLBACK");
    return false;
}

static bool prepare_put(struct store *st, char *why, size_t size)
{
    snprintf(why, size, "a table is missing");
    return store_evict_prepare(st)
        && (st->put = store_file_prepare(st->cache, "INSERT OR REPLACE INTO results(id, made, result, sum) VALUES(?1, ?2, ?3, ?4)", why, size));
}

static bool fresh_cache(struct store *st, char *why, size_t size)
{
    sqlite3_finalize(st->put);
    sqlite3_close(st->cache);
    st->put = NULL;
    return (st->cache = store_file_fresh(st->folder, FILE_CACHE, why, size)) && prepare_put(st, why, size);
}

/* A cache that broke while it was in use. Readers open the new file when they notice. */
static void renew_cache(struct store *st)
{
    char why[512];
    if (fresh_cache(st, why, sizeof why)) {
        atomic_store(&st->cache_broken, false);
        atomic_fetch_add(&st->cache_age, 1);
        log_event(LOG_L_WARN, "cache_dropped", "reason", "it was damaged", NULL);
    } else {
        log_event(LOG_L_ERROR, "cache_not_opened", "reason", why, NULL);
    }
}

/* *wrote: rows or, by a probe, the header were written, so that the disk has been heard. */
static bool write_jobs(struct store *st, const struct store_op *ops, bool *wrote)
{
    bool any = false, probed = false, ok;
    int before = sqlite3_total_changes(st->queue);
    *wrote = false;
    for (const struct store_op *op = ops; op; op = op->next) {
        any |= op->kind != OP_BARRIER && op->kind != OP_TOUCH;
        probed |= op->kind == OP_PROBE;
    }
    if (!any)
        return true;
    ok = exec(st->queue, "BEGIN IMMEDIATE");
    for (const struct store_op *op = ops; ok && op; op = op->next)
        ok = apply(st, op);
    if (ok && exec(st->queue, "COMMIT")) {
        metrics_add(st->metrics, METRIC_STORE_COMMITS);
        *wrote = probed || sqlite3_total_changes(st->queue) != before;
        return true;
    }
    log_event(LOG_L_ERROR, "queue_write_failed", "reason", sqlite3_errmsg(st->queue), NULL);
    exec(st->queue, "ROLLBACK");
    return false;
}

static void keep_cache_small(struct store *st, const struct store_op *ops)
{
    bool grown = false;
    for (const struct store_op *op = ops; op; op = op->next) {
        grown |= op->kind == OP_END && op->text.at;
        if (op->kind == OP_TOUCH)
            store_evict_touch(st, &op->row);
    }
    if (grown)
        store_evict(st);
}

static void commit(struct store *st, struct store_op *ops)
{
    /* A result that could not be kept is only a cache miss later: the end still stands. */
    if (atomic_load(&st->cache_broken))
        renew_cache(st);
    bool cached = st->put && put_results(st, ops);
    bool wrote, queued = write_jobs(st, ops, &wrote);
    if (cached)
        keep_cache_small(st, ops);
    if (!cached || !queued)
        metrics_add(st->metrics, METRIC_STORE_FAILURES);
    if (wrote || !queued)         /* a batch that writes nothing says nothing of the disk */
        atomic_store(&st->healthy, queued);
    while (ops) {
        struct store_op *op = ops;
        ops = op->next;
        if (op->done)
            op->done(op->ctx, queued);
        free(op);
    }
}

static void *writer(void *arg)
{
    struct store *st = arg;
    for (;;) {
        pthread_mutex_lock(&st->lock);
        while (!st->first && !st->stop)
            pthread_cond_wait(&st->work, &st->lock);
        struct store_op *ops = st->first;
        st->first = NULL;
        st->last = &st->first;
        pthread_mutex_unlock(&st->lock);
        if (!ops)
            return NULL;
        commit(st, ops);
    }
}

static bool submit(struct store *st, enum store_op_kind kind, const struct job_row *row, struct slice text, store_done *done, void *ctx)
{
    struct store_op *op = calloc(1, sizeof *op);
    if (!op)
        return false;
    *op = (struct store_op){ .kind = kind, .text = text, .done = done, .ctx = ctx };
    if (row)
        op->row = *row;
    pthread_mutex_lock(&st->lock);
    *st->last = op;
    st->last = &op->next;
    pthread_cond_signal(&st->work);
    pthread_mutex_unlock(&st->lock);
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
    return atomic_load(&st->healthy);
}

static bool prepare_writer(struct store *st, char *why, size_t size)
{
    sqlite3 *q = st->queue;
    return (st->insert = store_file_prepare(q, "INSERT OR REPLACE INTO jobs(id, status, attempts, created, started, finished, request, sum, owner)"
                                               " VALUES(?1, ?2, 0, ?3, 0, 0, ?4, ?5, ?6)", why, size))
        && (st->started = store_file_prepare(q, "UPDATE jobs SET status=1, started=?2 WHERE id=?1", why, size))
        && (st->requeue = store_file_prepare(q, "UPDATE jobs SET status=0, started=0 WHERE id=?1", why, size))
        && (st->end = store_file_prepare(q, "UPDATE jobs SET status=?2, started=?3, finished=?4, error=?5 WHERE id=?1", why, size));
}

/* A cache whose tables are not what they should be is damaged too. */
static bool prepare_cache(struct store *st, char *why, size_t size)
{
    if (prepare_put(st, why, size))
        return true;
    log_event(LOG_L_WARN, "cache_dropped", "reason", why, NULL);
    return fresh_cache(st, why, size);
}

/* Everything but the thread. */
static bool open_parts(struct store *st, const char *folder, char *why, size_t size)
{
    return (st->folder = strdup(folder)) && (st->lock_fd = store_file_lock(folder, why, size)) >= 0
        && (st->queue = store_file_open(folder, FILE_QUEUE, true, why, size))
        && (st->cache = store_file_open(folder, FILE_CACHE, true, why, size))
        && prepare_writer(st, why, size) && prepare_cache(st, why, size)
        && store_readers_open(st, folder, why, size);
}

struct store *store_open(const char *folder, struct metrics *m, char *why, size_t size)
{
    struct store *st = calloc(1, sizeof *st);
    if (!st) {
        snprintf(why, size, "out of memory");
        return NULL;
    }
    st->lock_fd = -1;
    st->metrics = m;
    st->last = &st->first;
    atomic_init(&st->healthy, true);
    pthread_mutex_init(&st->lock, NULL);
    pthread_cond_init(&st->work, NULL);
    pthread_mutex_init(&st->read_lock, NULL);
    pthread_cond_init(&st->read_free, NULL);
    if (open_parts(st, folder, why, size) && (st->has_thread = pthread_create(&st->thread, NULL, writer, st) == 0))
        return st;
    store_close(st);
    return NULL;
}

void store_close(struct store *st)
{
    if (!st)
        return;
    if (st->has_thread) {
        pthread_mutex_lock(&st->lock);
        st->stop = true;
        pthread_cond_signal(&st->work);
        pthread_mutex_unlock(&st->lock);
        pthread_join(st->thread, NULL);
    }
    store_readers_close(st);
    sqlite3_stmt *const statements[] = { st->insert, st->started, st->requeue, st->end, st->put };
    for (size_t i = 0; i < sizeof statements / sizeof *statements; i++)
        sqlite3_finalize(statements[i]);
    sqlite3_close(st->cache);
    sqlite3_close(st->queue);
    if (st->lock_fd >= 0)
        close(st->lock_fd);
    free(st->folder);
    free(st);
}

/* The writer's connection is used here from another thread, which is safe since nothing has
 * been submitted yet; the walk has a reader's, because what is told may submit. */
bool store_recover(struct store *st, void (*each)(void *ctx, const struct job_row *row), void *ctx, char *why, size_t size)
{
    if (!exec(st->queue, "UPDATE jobs SET attempts = attempts + 1, status = 0, started = 0 WHERE status = 1")) {
        snprintf(why, size, "the queue cannot be recovered: %s", sqlite3_errmsg(st->queue));
        return false;
    }
    sqlite3_stmt *s = store_file_prepare(st->reader[0].queue, "SELECT " STORE_ROW_COLUMNS " FROM jobs WHERE status = 0 ORDER BY seq", why, size);
    if (!s)
        return false;
    int rc;
    while ((rc = sqlite3_step(s)) == SQLITE_ROW) {
        struct job_row row;
        if (store_read_row(s, &row))
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
