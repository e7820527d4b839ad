/* Writing cache.db, on a thread of its own: results are large, and a disk may be slow. */
#include "store_parts.h"
#include "log.h"
#include "metrics.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

static bool is_result(const struct store_op *op)
{
    return op->kind == OP_END && op->text.at;
}

static size_t count_results(const struct store_op *ops)
{
    size_t n = 0;
    for (; ops; ops = ops->next)
        n += is_result(ops);
    return n;
}

static int64_t bytes_of_results(const struct store_op *ops)
{
    int64_t bytes = 0;
    for (; ops; ops = ops->next)
        bytes += is_result(ops) ? (int64_t)ops->text.len : 0;
    return bytes;
}

/* Does the result of a later run stand there? One whose row was damaged, its epoch too perhaps, gives way: who reads it would have the job run
 * again and again. */
static bool stands(struct lite *st, const char *id)
{
    sqlite3_stmt *row = NULL, *pieces = NULL, *gone = NULL;
    bool ok = sqlite3_prepare_v2(st->cache, "SELECT id, result, sum FROM results WHERE id=?1", -1, &row, NULL) == SQLITE_OK
        && sqlite3_prepare_v2(st->cache, STORE_PIECES, -1, &pieces, NULL) == SQLITE_OK
        && sqlite3_prepare_v2(st->cache, "DELETE FROM results WHERE id=?1", -1, &gone, NULL) == SQLITE_OK
        && sqlite3_bind_text(row, 1, id, -1, SQLITE_STATIC) == SQLITE_OK && sqlite3_step(row) == SQLITE_ROW && store_pieces_genuine(row, pieces);
    sqlite3_finalize(row);
    sqlite3_finalize(pieces);
    if (!ok && gone) {
        store_bind_text(gone, 1, id);
        store_step(gone);
    }
    sqlite3_finalize(gone);
    return ok;
}

/* A row that is there goes, and is not changed: so its entries in the indices are written too, which may be damaged on the disk while the
 * writer has them as they were; readers, which do not find it by them, would have the job run again and again. */
static bool put_row(struct lite *st, const struct store_op *op)
{
    struct slice first = store_pieces_first(op->text);
    store_bind_text(st->make_way, 1, op->row.id);
    sqlite3_bind_int64(st->make_way, 2, op->row.epoch);
    if (!store_step(st->make_way))
        return false;
    store_bind_text(st->put, 1, op->row.id);
    sqlite3_bind_int64(st->put, 2, op->row.finished);
    sqlite3_bind_blob64(st->put, 3, first.at, first.len, SQLITE_STATIC);
    store_bind_sum(st->put, 4, op->row.id, op->text);
    sqlite3_bind_int64(st->put, 5, op->row.epoch);
    return store_step(st->put);
}

static bool put_one(struct lite *st, const struct store_op *op)
{
    assert(is_result(op) && op->row.status == JOB_DONE);
    if (!put_row(st, op))
        return false;
    bool kept = sqlite3_changes(st->cache) > 0;
    if (!kept && !stands(st, op->row.id)) {
        if (!put_row(st, op))
            return false;
        kept = sqlite3_changes(st->cache) > 0;
    }
    return !kept || store_pieces_put(st->cache, op->row.id, op->text);
}

/* In one transaction. *begun: the file was to be had at all. */
static bool put_results(struct lite *st, const struct store_op *ops, bool *begun)
{
    bool ok = *begun = store_exec(st->cache, "BEGIN IMMEDIATE");
    for (const struct store_op *op = ops; ok && op; op = op->next)
        if (is_result(op))
            ok = put_one(st, op);
    if (ok && store_exec(st->cache, "COMMIT"))
        return true;
    if (store_file_broken(sqlite3_errcode(st->cache)))
        atomic_store(&st->cache_broken, true);
    int code = sqlite3_errcode(st->cache) & 0xff;
    st->cache_full = code == SQLITE_FULL || (code == SQLITE_IOERR && sqlite3_system_errno(st->cache) == EDQUOT);
    log_event(LOG_L_ERROR, "cache_write_failed", "reason", sqlite3_errmsg(st->cache), NULL);
    store_exec(st->cache, "ROLLBACK");
    return false;
}

static bool prepare_put(struct lite *st, char *why, size_t size)
{
    snprintf(why, size, "a table is missing");
    return store_evict_prepare(st) && store_pieces_prepare(st->cache)
        && (st->make_way = store_file_prepare(st->cache, "DELETE FROM results WHERE id=?1 AND epoch <= ?2", why, size))
        && (st->put = store_file_prepare(st->cache, "INSERT INTO results(id, made, result, sum, epoch) VALUES(?1, ?2, ?3, ?4, ?5)"
                                                      " ON CONFLICT(id) DO NOTHING", why, size));
}

static bool fresh_cache(struct lite *st, char *why, size_t size)
{
    sqlite3_finalize(st->make_way);
    sqlite3_finalize(st->put);
    sqlite3_close(st->cache);
    st->make_way = st->put = NULL;
    return (st->cache = store_file_fresh(st->folder, FILE_CACHE, why, size)) && prepare_put(st, why, size);
}

/* A cache whose tables are not what they should be is damaged too. */
bool store_cache_prepare(struct lite *st, char *why, size_t size)
{
    if (prepare_put(st, why, size))
        return true;
    log_event(LOG_L_WARN, "cache_dropped", "reason", why, NULL);
    return fresh_cache(st, why, size);
}

/* A cache that broke while it was in use. Readers open the new file when they notice. */
static void renew_cache(struct lite *st)
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

static void keep_cache_small(struct lite *st, const struct store_op *ops, int64_t bytes)
{
    bool grown = false;
    for (const struct store_op *op = ops; op; op = op->next) {
        grown |= op->kind == OP_END && op->text.at;
        if (op->kind == OP_TOUCH)
            store_evict_touch(st, &op->row);
        if (op->kind == OP_PRUNE_RESULTS)
            store_evict_kept(st, &op->keep);
    }
    if (grown)
        store_evict(st, bytes);
}

/* Those of the list that the queue is to have, in their order; the others are freed. */
static struct store_op *for_queue(struct store_op *ops)
{
    struct store_op *first = NULL, **last = &first;
    for (struct store_op *next; ops; ops = next) {
        next = ops->next;
        ops->next = NULL;
        if (store_op_of_cache(ops)) {
            free(ops);
        } else {
            *last = ops;
            last = &ops->next;
        }
    }
    return first;
}

/* Takes the first of the ends with a result whose text is shortest out of the list. */
static struct store_op *take_shortest(struct store_op **ops)
{
    struct store_op **best = NULL, *op;
    for (struct store_op **at = ops; *at; at = &(*at)->next)
        if (is_result(*at) && (!best || (*at)->text.len < (*best)->text.len))
            best = at;
    if (!best)
        return NULL;
    op = *best;
    *best = op->next;
    op->next = NULL;
    return op;
}

/* Who gave the end keeps it, and gives it again. It is told on the queue's thread, in its turn: the job itself may be on its way to the disk yet. */
static void give_back(struct store_op *op)
{
    assert(is_result(op) && op->done);
    op->kind = OP_BARRIER;
    op->how = STORE_LOST;
}

/* What failed together is written one by one, the shortest first, until one fails: what does not fit keeps nothing out that does.
 * The others are given back. Answers with all, those ends last. */
static struct store_op *put_apart(struct lite *st, struct store_op *ops, bool may, bool *some)
{
    struct store_op *ends = NULL, **last = &ends;
    bool begun;
    for (struct store_op *op; (op = take_shortest(&ops));) {
        may = may && put_results(st, op, &begun);
        *some |= may;
        if (!may)
            give_back(op);
        *last = op;
        last = &op->next;
    }
    struct store_op **end = &ops;
    while (*end)
        end = &(*end)->next;
    *end = ends;
    return ops;
}

/* No job is marked done whose result could not be kept: its end is tried again, and where the daemon ends before that it runs again. */
void store_cache_commit(struct lite *st, struct store_op *ops)
{
    bool begun = false, ok = true, some = false;
    size_t results = count_results(ops);
    int64_t bytes = bytes_of_results(ops);
    if (atomic_load(&st->cache_broken))
        renew_cache(st);
    if (results) {
        st->cache_full = false;
        ok = st->put && put_results(st, ops, &begun);
        if (!ok && st->cache_full && store_evict_for(st, bytes))      /* an old result makes room for a new one */
            ok = put_results(st, ops, &begun);
        if (!ok) {
            metrics_add(st->metrics, METRIC_STORE_FAILURES);
            ops = put_apart(st, ops, begun && results > 1 && !atomic_load(&st->cache_broken), &some);
        }
        atomic_store(&st->cache_failures, ok || some ? 0 : atomic_load(&st->cache_failures) + 1);
    }
    if (st->put)
        keep_cache_small(st, ops, bytes);
    store_writer_give(&st->queue_writer, for_queue(ops));
}
