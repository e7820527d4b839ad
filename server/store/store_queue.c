/* Writing queue.db. A 202 waits for its commit, and so does whoever is told of an end; nothing
 * here waits for results. */
#include "store_parts.h"
#include "budget.h"
#include "log.h"
#include "metrics.h"

#include <assert.h>
#include <stdlib.h>

enum { PAGE = 4096 };            /* what a row needs beside its text */

/* By age, or all but so many, or so many bytes. */
static bool prune_by(struct lite *st, sqlite3_stmt *s, int64_t bound)
{
    sqlite3_bind_int64(s, 1, bound);
    if (!store_step(s))
        return false;
    atomic_fetch_add(&st->metrics->counter[METRIC_PRUNED], (unsigned long)sqlite3_changes(st->queue));
    return true;
}

static bool prune(struct lite *st, const struct store_keep *k)
{
    if ((k->since && !prune_by(st, st->prune_age, k->since)) || (k->jobs && !prune_by(st, st->prune_count, k->jobs)))
        return false;
    int64_t excess = k->bytes ? store_bytes_used(st->queue) - k->bytes : 0;
    return excess <= 0 || prune_by(st, st->prune_bytes, excess);
}

/* A statement that changed nothing came from a run that is over. */
static bool fenced(struct lite *st, struct store_op *op, bool ok)
{
    if (ok && sqlite3_changes(st->queue) == 0)
        op->how = STORE_FENCED;
    return ok;
}

/* One that was kept before is kept. */
static bool end(struct lite *st, struct store_op *op)
{
    const struct job_row *r = &op->row;
    sqlite3_stmt *s = st->end;
    assert(job_ended(r->status) && (r->status != JOB_DONE || !r->error));
    store_bind_text(s, 1, r->id);
    sqlite3_bind_int(s, 2, r->status);
    sqlite3_bind_int64(s, 3, r->started);
    sqlite3_bind_int64(s, 4, r->finished);
    store_bind_text(s, 5, r->error);
    sqlite3_bind_int64(s, 6, r->epoch);
    if (!fenced(st, op, store_step(s)))
        return false;
    if (op->how == STORE_KEPT)
        return true;
    s = st->ended;
    store_bind_text(s, 1, r->id);
    sqlite3_bind_int(s, 2, r->status);
    sqlite3_bind_int64(s, 3, r->epoch);
    int rc = sqlite3_step(s);
    sqlite3_reset(s);
    sqlite3_clear_bindings(s);
    if (rc == SQLITE_ROW)
        op->how = STORE_KEPT;
    return rc == SQLITE_ROW || rc == SQLITE_DONE;
}

static bool apply(struct lite *st, struct store_op *op)
{
    const struct job_row *r = &op->row;
    sqlite3_stmt *s;
    switch (op->kind) {
    case OP_SUBMIT:
        return lite_decide_submit(st, op);
    case OP_CANCEL:
        return lite_decide_cancel(st, op);
    case OP_CLAIM:
        return lite_decide_claim(st, op);
    case OP_BEAT:
        return lite_decide_beat(st, op);
    case OP_REAP:
        return lite_decide_reap(st, op);
    case OP_STARTED:
        s = st->started;
        store_bind_text(s, 1, r->id);
        sqlite3_bind_int64(s, 2, r->started);
        sqlite3_bind_int(s, 3, r->attempts);
        sqlite3_bind_int64(s, 4, r->epoch);
        return store_step(s);
    case OP_RELEASE:
        s = st->release;
        store_bind_text(s, 1, r->id);
        sqlite3_bind_int(s, 2, r->attempts);
        sqlite3_bind_int64(s, 3, r->epoch);
        sqlite3_bind_int64(s, 4, op->anew);
        store_bind_text(s, 5, r->error);
        sqlite3_bind_int64(s, 6, r->finished);
        return fenced(st, op, store_step(s));
    case OP_END:
        return end(st, op);
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
        return prune(st, &op->keep);
    case OP_PROBE:
        return store_file_fill(st->queue, atomic_load(&st->needed));
    default:
        assert(op->kind == OP_BARRIER);      /* reads of results are the other thread's */
        return true;
    }
}

static size_t largest(const struct store_op *ops)
{
    size_t most = 0;
    for (const struct store_op *op = ops; op; op = op->next)
        if (op->kind == OP_SUBMIT && op->text.len > most)
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

static bool write_all(struct lite *st, struct store_op *ops)
{
    bool ok = !atomic_load(&st->moved) && store_exec(st->queue, "BEGIN IMMEDIATE");
    if (ok && st->life_unsaved)
        ok = lite_save_life(st);
    for (struct store_op *op = ops; ok && op; op = op->next)
        ok = apply(st, op);
    if (ok && store_exec(st->queue, "COMMIT")) {
        st->life_unsaved = false;
        return true;
    }
    log_event(LOG_L_ERROR, "queue_write_failed", "reason", atomic_load(&st->moved) ? "the state folder is gone" : sqlite3_errmsg(st->queue), NULL);
    store_exec(st->queue, "ROLLBACK");
    return false;
}

/* What the disk took, or did not, tells whether jobs can be accepted: after a failure only a write
 * of as many bytes as failed brings the readiness back, not a small one that still fits. */
static void heard(struct lite *st, const struct store_op *ops, bool ok)
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

void store_queue_commit(struct lite *st, struct store_op *ops)
{
    store_look(&st->face);
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
            op->done(op->ctx, ok ? op->how : STORE_LOST);
        free(op);
    }
}

bool store_queue_prepare(struct lite *st, char *why, size_t size)
{
    sqlite3 *q = st->queue;
    return (st->known = store_file_prepare(q, "SELECT status, owner FROM jobs WHERE id=?1", why, size))
        && (st->insert = store_file_prepare(q, "INSERT OR REPLACE INTO jobs(id, status, attempts, created, started, finished, request, sum, owner, seconds, epoch)"
                                               " VALUES(?1, 0, 0, ?3, 0, 0, ?4, ?5, ?6, ?7, ?8)", why, size))
        && (st->started = store_file_prepare(q, "UPDATE jobs SET status=1, started=?2, attempts=?3, epoch=?4 WHERE id=?1", why, size))
        && (st->release = store_file_prepare(q, "UPDATE jobs SET status=CASE WHEN cancel THEN 4 ELSE 0 END, error=CASE WHEN cancel THEN ?5 END,"
                                                " finished=CASE WHEN cancel THEN ?6 ELSE 0 END, started=0, lease=0, attempts=?2, epoch=?4"
                                                " WHERE id=?1 AND status < 2 AND epoch <= ?3", why, size))
        && (st->join = store_file_prepare(q, "INSERT OR REPLACE INTO interests(id, owner, status)"
                                             " VALUES(?1, ?2, coalesce((SELECT status FROM jobs WHERE id=?1), 0))", why, size))
        && (st->note = store_file_prepare(q, "INSERT OR IGNORE INTO interests(id, owner, status) SELECT id, ?2, status FROM jobs WHERE id=?1", why, size))
        && (st->prune_age = store_file_prepare(q, "DELETE FROM jobs WHERE seq IN (SELECT seq FROM jobs WHERE status >= 2 AND finished < ?1"
                                                  " ORDER BY finished LIMIT 1000)", why, size))
        && (st->prune_count = store_file_prepare(q, "DELETE FROM jobs WHERE seq IN (SELECT seq FROM jobs WHERE status >= 2"
                                                    " ORDER BY finished DESC LIMIT 1000 OFFSET ?1)", why, size))
        && (st->prune_bytes = store_file_prepare(q, "DELETE FROM jobs WHERE seq IN (SELECT seq FROM (SELECT seq, sum(n) OVER (ORDER BY finished, seq) - n AS before"
                                                    " FROM (SELECT seq, finished, length(request) AS n FROM jobs WHERE status >= 2 ORDER BY finished LIMIT 1000))"
                                                    " WHERE before < ?1)", why, size))
        && (st->withdraw = store_file_prepare(q, "DELETE FROM interests WHERE id=?1 AND owner=?2", why, size))
        && (st->forget = store_file_prepare(q, "DELETE FROM jobs WHERE id=?1 AND status >= 2", why, size))
        && (st->end = store_file_prepare(q, "UPDATE jobs SET status=?2, started=?3, finished=?4, error=?5, lease=0, epoch=?6"
                                            " WHERE id=?1 AND status < 2 AND epoch <= ?6", why, size))
        && (st->ended = store_file_prepare(q, "SELECT 1 FROM jobs WHERE id=?1 AND status=?2 AND epoch=?3", why, size));
}
