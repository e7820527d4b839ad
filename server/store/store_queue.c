/* Writing queue.db. A 202 waits for its commit, and so does whoever is told of an end; nothing
 * here waits for results. */
#include "store_parts.h"
#include "budget.h"
#include "log.h"
#include "metrics.h"

#include <stdlib.h>

enum { PAGE = 4096 };            /* what a row needs beside its text */

/* By age, or all but so many. */
static bool prune(struct store *st, sqlite3_stmt *s, int64_t bound)
{
    sqlite3_bind_int64(s, 1, bound);
    if (!store_step(s))
        return false;
    atomic_fetch_add(&st->metrics->counter[METRIC_PRUNED], (unsigned long)sqlite3_changes(st->queue));
    return true;
}

static bool apply(struct store *st, const struct store_op *op)
{
    const struct job_row *r = &op->row;
    sqlite3_stmt *s;
    switch (op->kind) {
    case OP_INSERT:
        s = st->insert;
        store_bind_text(s, 1, r->id);
        sqlite3_bind_int(s, 2, r->status);
        sqlite3_bind_int64(s, 3, r->created);
        sqlite3_bind_blob64(s, 4, op->text.at, op->text.len, SQLITE_STATIC);
        store_bind_sum(s, 5, r->id, op->text);
        store_bind_text(s, 6, r->owner);
        sqlite3_bind_int64(s, 7, r->seconds);
        return store_step(s);
    case OP_STARTED:
        s = st->started;
        store_bind_text(s, 1, r->id);
        sqlite3_bind_int64(s, 2, r->started);
        sqlite3_bind_int(s, 3, r->attempts);
        return store_step(s);
    case OP_REQUEUE:
        s = st->requeue;
        store_bind_text(s, 1, r->id);
        sqlite3_bind_int(s, 2, r->attempts);
        return store_step(s);
    case OP_END:
        s = st->end;
        store_bind_text(s, 1, r->id);
        sqlite3_bind_int(s, 2, r->status);
        sqlite3_bind_int64(s, 3, r->started);
        sqlite3_bind_int64(s, 4, r->finished);
        store_bind_text(s, 5, r->error);
        return store_step(s);
    case OP_JOIN:
    case OP_NOTE:
    case OP_WITHDRAW:
        s = op->kind == OP_JOIN ? st->join : op->kind == OP_NOTE ? st->note : st->withdraw;
        store_bind_text(s, 1, r->id);
        store_bind_text(s, 2, r->owner);
        return store_step(s);
    case OP_FORGET:
        s = st->forget;
        store_bind_text(s, 1, r->id);
        return store_step(s);
    case OP_PRUNE:
        return (!r->finished || prune(st, st->prune_age, r->finished)) && (!r->seq || prune(st, st->prune_count, r->seq));
    case OP_PROBE:
        return store_file_fill(st->queue, atomic_load(&st->needed));
    default:
        return true;
    }
}

static size_t largest(const struct store_op *ops)
{
    size_t most = 0;
    for (const struct store_op *op = ops; op; op = op->next)
        if (op->kind == OP_INSERT && op->text.len > most)
            most = op->text.len;
    return most + PAGE;
}

static bool any(const struct store_op *ops, enum store_op_kind kind)
{
    while (ops && ops->kind != kind)
        ops = ops->next;
    return ops;
}

static bool writes(const struct store_op *ops)
{
    while (ops && ops->kind == OP_BARRIER)
        ops = ops->next;
    return ops;
}

static bool write_all(struct store *st, const struct store_op *ops)
{
    bool ok = !atomic_load(&st->moved) && store_exec(st->queue, "BEGIN IMMEDIATE");
    for (const struct store_op *op = ops; ok && op; op = op->next)
        ok = apply(st, op);
    if (ok && store_exec(st->queue, "COMMIT"))
        return true;
    log_event(LOG_L_ERROR, "queue_write_failed", "reason", atomic_load(&st->moved) ? "the state folder is gone" : sqlite3_errmsg(st->queue), NULL);
    store_exec(st->queue, "ROLLBACK");
    return false;
}

/* What the disk took, or did not, tells whether jobs can be accepted: after a failure only a write
 * of as many bytes as failed brings the readiness back, not a small one that still fits. */
static void heard(struct store *st, const struct store_op *ops, bool ok)
{
    size_t size = largest(ops), needed = atomic_load(&st->needed);
    if (!ok) {
        atomic_store(&st->needed, size > needed ? size : needed);
        atomic_store(&st->healthy, false);
        metrics_add(st->metrics, METRIC_STORE_FAILURES);
        return;
    }
    metrics_add(st->metrics, METRIC_STORE_COMMITS);
    if (any(ops, OP_PROBE)) {
        store_file_fill(st->queue, 0);
        atomic_store(&st->needed, 0);
        atomic_store(&st->healthy, true);
    }
}

void store_queue_commit(struct store *st, struct store_op *ops)
{
    store_look(st);
    double began = sga_now();
    bool ok = !writes(ops) || write_all(st, ops);
    if (writes(ops)) {
        metrics_committed(st->metrics, sga_now() - began);
        heard(st, ops, ok);
    }
    while (ops) {
        struct store_op *op = ops;
        ops = op->next;
        if (op->done)
            op->done(op->ctx, ok);
        free(op);
    }
}

bool store_queue_prepare(struct store *st, char *why, size_t size)
{
    sqlite3 *q = st->queue;
    return (st->insert = store_file_prepare(q, "INSERT OR REPLACE INTO jobs(id, status, attempts, created, started, finished, request, sum, owner, seconds)"
                                               " VALUES(?1, ?2, 0, ?3, 0, 0, ?4, ?5, ?6, ?7)", why, size))
        && (st->started = store_file_prepare(q, "UPDATE jobs SET status=1, started=?2, attempts=?3 WHERE id=?1", why, size))
        && (st->requeue = store_file_prepare(q, "UPDATE jobs SET status=0, started=0, attempts=?2 WHERE id=?1", why, size))
        && (st->join = store_file_prepare(q, "INSERT OR REPLACE INTO interests(id, owner, status)"
                                             " VALUES(?1, ?2, coalesce((SELECT status FROM jobs WHERE id=?1), 0))", why, size))
        && (st->note = store_file_prepare(q, "INSERT OR IGNORE INTO interests(id, owner, status) SELECT id, ?2, status FROM jobs WHERE id=?1", why, size))
        && (st->prune_age = store_file_prepare(q, "DELETE FROM jobs WHERE seq IN (SELECT seq FROM jobs WHERE status >= 2 AND finished < ?1"
                                                  " ORDER BY finished LIMIT 1000)", why, size))
        && (st->prune_count = store_file_prepare(q, "DELETE FROM jobs WHERE seq IN (SELECT seq FROM jobs WHERE status >= 2"
                                                    " ORDER BY finished DESC LIMIT 1000 OFFSET ?1)", why, size))
        && (st->withdraw = store_file_prepare(q, "DELETE FROM interests WHERE id=?1 AND owner=?2", why, size))
        && (st->forget = store_file_prepare(q, "DELETE FROM jobs WHERE id=?1 AND status >= 2", why, size))
        && (st->end = store_file_prepare(q, "UPDATE jobs SET status=?2, started=?3, finished=?4, error=?5 WHERE id=?1", why, size));
}
