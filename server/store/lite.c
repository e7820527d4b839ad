/* The store of one daemon, in files: its life, and what its callers give to its writers. */
#include "store_parts.h"
#include "log.h"
#include "metrics.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TOUCHES = 4096 };      /* that may wait: more are not worth their memory */
enum { FAILURES_SEEN = 3 };   /* of results, in a row: then whoever asks whether the store is well is told no */
static const long long LIFE = 1LL << 32;      /* epochs of one */

/* Ends with a result come to the queue's thread by way of the results'. */
static struct store_writer *writer_of(struct lite *st, const struct store_op *op)
{
    return store_op_of_cache(op) || (op->kind == OP_END && op->text.at) ? &st->cache_writer : &st->queue_writer;
}

bool lite_submit(struct lite *st, struct store_op op)
{
    struct store_op *copy = malloc(sizeof *copy);
    if (!copy)
        return false;
    *copy = op;
    copy->how = STORE_KEPT;
    store_writer_give(writer_of(st, copy), copy);
    return true;
}

static void lite_limit(struct store *face, const atomic_long *cache_bytes)
{
    struct lite *st = lite_of(face);
    st->cache_limit = cache_bytes;
}

static void lite_touch(struct store *face, const char *id, int64_t now)
{
    struct lite *st = lite_of(face);
    struct store_op op = { .kind = OP_TOUCH, .row = { .finished = now } };
    snprintf(op.row.id, sizeof op.row.id, "%s", id);
    if (st->cache_writer.count < TOUCHES)      /* a hint: read without the lock */
        lite_submit(st, op);
}

static bool lite_submission(struct store *face, struct store_submission *s, store_done *done, void *ctx)
{
    return lite_submit(lite_of(face), (struct store_op){ .kind = OP_SUBMIT, .row = s->row, .text = s->request, .what = s, .done = done, .ctx = ctx });
}

static bool lite_started(struct store *face, const struct job_row *row)
{
    return lite_submit(lite_of(face), (struct store_op){ .kind = OP_STARTED, .row = *row });
}

static bool lite_release(struct store *face, const struct job_row *row, int64_t *next, store_done *done, void *ctx)
{
    struct store_op op = { .kind = OP_RELEASE, .row = *row, .done = done, .ctx = ctx, .anew = store_epoch(face) };
    if (next)
        *next = op.anew;
    return lite_submit(lite_of(face), op);
}

static bool lite_end(struct store *face, const struct job_row *row, struct slice result, store_done *done, void *ctx)
{
    return lite_submit(lite_of(face), (struct store_op){ .kind = OP_END, .row = *row, .text = result, .done = done, .ctx = ctx });
}

static bool lite_cancel(struct store *face, struct store_cancel *c, store_done *done, void *ctx)
{
    return lite_submit(lite_of(face), (struct store_op){ .kind = OP_CANCEL, .what = c, .done = done, .ctx = ctx });
}

static bool submit_interest(struct store *face, enum store_op_kind kind, const char *id, const char *owner)
{
    struct store_op op = { .kind = kind };
    snprintf(op.row.id, sizeof op.row.id, "%s", id);
    snprintf(op.row.owner, sizeof op.row.owner, "%s", owner);
    return lite_submit(lite_of(face), op);
}

static bool lite_join(struct store *face, const char *id, const char *owner)
{
    return submit_interest(face, OP_JOIN, id, owner);
}

static bool lite_note(struct store *face, const char *id, const char *owner)
{
    return submit_interest(face, OP_NOTE, id, owner);
}

static bool lite_withdraw(struct store *face, const char *id, const char *owner)
{
    return submit_interest(face, OP_WITHDRAW, id, owner);
}

static bool lite_forget(struct store *face, const char *id)
{
    return submit_interest(face, OP_FORGET, id, "");
}

static bool lite_prune(struct store *face, const struct store_keep *keep)
{
    bool jobs = keep->since || keep->jobs || keep->bytes, results = keep->results_since || keep->results;
    return (!jobs || lite_submit(lite_of(face), (struct store_op){ .kind = OP_PRUNE, .keep = *keep }))
        && (!results || lite_submit(lite_of(face), (struct store_op){ .kind = OP_PRUNE_RESULTS, .keep = *keep }));
}

static bool lite_barrier(struct store *face, store_done *done, void *ctx)
{
    return lite_submit(lite_of(face), (struct store_op){ .kind = OP_BARRIER, .done = done, .ctx = ctx });
}

static int64_t lite_epoch(struct store *face)
{
    return atomic_fetch_add(&lite_of(face)->epoch, 1) + 1;
}

static void lite_probe(struct store *face)
{
    struct lite *st = lite_of(face);
    lite_submit(st, (struct store_op){ .kind = OP_PROBE });
}

static bool lite_healthy(struct store *face)
{
    struct lite *st = lite_of(face);
    return atomic_load(&st->healthy) && !atomic_load(&st->moved) && atomic_load(&st->cache_failures) < FAILURES_SEEN;
}

static unsigned long long lite_free_bytes(struct store *face)
{
    struct lite *st = lite_of(face);
    return atomic_load(&st->free_bytes);
}

static unsigned long long lite_bytes(struct store *face, bool results)
{
    return store_place_bytes(lite_of(face)->folder, results ? "cache.db" : "queue.db");
}

static void lite_look(struct store *face)
{
    struct lite *st = lite_of(face);
    struct store_place now;
    bool moved = !store_place_of(st->folder, &now) || !store_place_same(&now, &st->place);
    if (moved != atomic_exchange(&st->moved, moved))
        log_event(LOG_L_ERROR, moved ? "state_folder_gone" : "state_folder_back", "state", st->folder, NULL);
    atomic_store(&st->free_bytes, store_place_free(st->folder));
}

/* The epochs of one life have its number above and a count below. */
static bool begin_life(struct lite *st, char *why, size_t size)
{
    sqlite3_stmt *s = store_file_prepare(st->queue, "SELECT coalesce(max(number), 0) FROM lives", why, size);
    if (!s)
        return false;
    bool ok = sqlite3_step(s) == SQLITE_ROW;
    atomic_store(&st->epoch, (sqlite3_column_int64(s, 0) + 1) * LIFE);
    st->life_unsaved = true;
    sqlite3_finalize(s);
    return ok;
}

bool lite_save_life(struct lite *st)
{
    char sql[100];
    snprintf(sql, sizeof sql, "INSERT OR REPLACE INTO lives(one, number) VALUES(1, %lld)", (long long)(atomic_load(&st->epoch) / LIFE));
    return store_exec(st->queue, sql);
}

/* Everything but the thread. */
static bool open_parts(struct lite *st, const char *folder, double wait, char *why, size_t size)
{
    return (st->folder = strdup(folder)) && (st->lock_fd = store_file_lock(folder, wait, why, size)) >= 0
        && store_place_sound(folder, why, size)
        && (st->queue = store_file_open(folder, FILE_QUEUE, true, why, size))
        && store_place_of(folder, &st->place) && store_place_mark(folder, why, size)
        && (atomic_store(&st->free_bytes, store_place_free(folder)), true)
        && (st->cache = store_file_open(folder, FILE_CACHE, true, why, size))
        && begin_life(st, why, size) && store_queue_prepare(st, why, size) && store_cache_prepare(st, why, size)
        && store_readers_open(st, folder, why, size);
}

static void lite_close(struct store *face)
{
    struct lite *st = lite_of(face);
    store_writer_stop(&st->cache_writer);      /* first: it gives to the other */
    store_writer_stop(&st->queue_writer);
    store_readers_close(st);
    sqlite3_stmt *const statements[] = { st->known, st->insert, st->started, st->release, st->end, st->ended, st->join, st->note, st->withdraw, st->forget,
                                         st->prune_age, st->prune_count, st->prune_bytes, st->make_way, st->put };
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
static void take_back(struct lite *st)
{
    char sql[200];
    snprintf(sql, sizeof sql, "UPDATE jobs SET attempts = attempts + 1, status = 0, started = 0, lease = 0, epoch = %lld WHERE status = 1",
             (long long)store_epoch(&st->face));
    if (lite_save_life(st) && store_exec(st->queue, sql))
        return;
    log_event(LOG_L_ERROR, "queue_write_failed", "reason", sqlite3_errmsg(st->queue), NULL);
    atomic_store(&st->healthy, false);
}

/* The writer's connection is used here from another thread, which is safe since nothing has
 * been submitted yet; the walk has a reader's, because what is told may submit. */
static bool lite_recover(struct store *face, void (*each)(void *ctx, const struct job_row *row), void *ctx, char *why, size_t size)
{
    struct lite *st = lite_of(face);
    assert(st->life_unsaved && st->queue_writer.count == 0);
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
        row.epoch = store_epoch(face);         /* also where the row could not be changed */
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

static const struct store_ops ops = {
    .close = lite_close, .limit = lite_limit, .healthy = lite_healthy, .free_bytes = lite_free_bytes, .bytes = lite_bytes, .probe = lite_probe, .look = lite_look, .touch = lite_touch,
    .submit = lite_submission, .end = lite_end, .release = lite_release, .cancel = lite_cancel, .join = lite_join, .note = lite_note,
    .withdraw = lite_withdraw, .forget = lite_forget, .prune = lite_prune, .barrier = lite_barrier,
    .claim = lite_claim, .beat = lite_beat, .reap = lite_reap, .look_at = lite_look_at,
    .job = lite_job, .request = lite_request, .result = lite_result, .owners = lite_owners, .owned = lite_owned, .list = lite_list,
    .started = lite_started, .epoch = lite_epoch, .used = lite_used, .recover = lite_recover,
};

struct store *store_open(const char *folder, double wait, struct metrics *m, char *why, size_t size)
{
    struct lite *st = calloc(1, sizeof *st);
    if (!st) {
        snprintf(why, size, "out of memory");
        return NULL;
    }
    st->face.ops = &ops;
    st->lock_fd = -1;
    st->metrics = m;
    atomic_init(&st->healthy, true);
    pthread_mutex_init(&st->read_lock, NULL);
    pthread_cond_init(&st->read_free, NULL);
    if (open_parts(st, folder, wait, why, size) && store_writer_start(&st->queue_writer, st, store_queue_commit)
        && store_writer_start(&st->cache_writer, st, store_cache_commit))
        return &st->face;
    lite_close(&st->face);
    return NULL;
}
