/* The decisions of the store of one daemon, inside the transaction of its queue's thread: who
 * asks for them waits for that. */
#include "store_parts.h"
#include "clock.h"

#include <assert.h>
#include <semaphore.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HOUR_MS = 3600000 };

/* One row of whole numbers; false where it cannot be read. `text` is bound to ?1, `number` to ?2. */
static bool numbers(struct lite *st, const char *sql, const char *text, int64_t number, int64_t *out, int count)
{
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(st->queue, sql, -1, &s, NULL) == SQLITE_OK;
    if (ok && text)
        store_bind_text(s, 1, text);
    if (ok && number)
        sqlite3_bind_int64(s, 2, number);
    ok = ok && sqlite3_step(s) == SQLITE_ROW;
    for (int i = 0; ok && i < count; i++)
        out[i] = sqlite3_column_int64(s, i);
    sqlite3_finalize(s);
    return ok;
}

/* The owner stands in the list of the job: at the top where it is new for him. */
static bool interest(struct lite *st, sqlite3_stmt *s, const char *id, const char *owner)
{
    (void)st;
    store_bind_text(s, 1, id);
    store_bind_text(s, 2, owner);
    return store_step(s);
}

static bool bounded(const struct store_room *r)
{
    return r->queue || r->queue_bytes || r->share || r->jobs || r->bytes || r->seconds;
}

/* Into s->outcome. The quota's words are those of quota.c. */
static bool room(struct lite *st, struct store_submission *s)
{
    const struct store_room *r = &s->room;
    int64_t all[2], own[3], used[1] = { 0 }, now = clock_ms(), bytes = (int64_t)s->request.len;
    if (!bounded(r))
        return true;
    if (!numbers(st, "SELECT count(*), coalesce(sum(length(request)), 0) FROM jobs WHERE status = 0", NULL, 0, all, 2)
        || !numbers(st, "SELECT count(*), coalesce(sum(CASE status WHEN 0 THEN length(request) END), 0), coalesce(sum(seconds), 0)"
                        " FROM jobs WHERE status < 2 AND owner = ?1", s->row.owner, 0, own, 3))
        return false;
    if (r->seconds && !numbers(st, "SELECT coalesce(sum(finished - max(started, ?2)), 0) / 1000 FROM jobs"
                                   " WHERE status >= 2 AND finished > ?2 AND started > 0 AND owner = ?1", s->row.owner, now - HOUR_MS, used, 1))
        return false;
    used[0] += r->used;
    int64_t taken = used[0] + own[2];
    s->retry = 5;
    s->quota = r->share && own[0] >= r->share ? "places in the queue"
        : r->jobs && own[0] >= r->jobs ? "jobs that wait or run"
        : r->bytes && own[1] + bytes > r->bytes ? "bytes of requests that wait"
        : r->seconds && (used[0] >= r->seconds || (taken > 0 && taken + s->row.seconds > r->seconds))
        ? "seconds of running in an hour, those that its waiting jobs may need included" : NULL;
    if ((r->queue && all[0] >= r->queue) || (r->queue_bytes && all[1] + bytes > r->queue_bytes))
        s->outcome = STORE_FULL;
    else if (s->quota)
        s->outcome = STORE_QUOTA;
    return true;
}

bool lite_decide_submit(struct lite *st, struct store_op *op)
{
    struct store_submission *s = op->what;
    const struct job_row *r = &op->row;
    s->outcome = STORE_NEW;
    store_bind_text(st->known, 1, r->id);
    int rc = sqlite3_step(st->known);
    int status = rc == SQLITE_ROW ? sqlite3_column_int(st->known, 0) : -1;
    sqlite3_reset(st->known);
    sqlite3_clear_bindings(st->known);
    if (rc != SQLITE_ROW && rc != SQLITE_DONE)
        return false;
    if (status == JOB_QUEUED || status == JOB_RUNNING || (status == JOB_DONE && !s->again)) {
        s->outcome = status == JOB_DONE ? STORE_DONE : STORE_JOINED;
        return !s->join || interest(st, st->note, r->id, r->owner);
    }
    if (!room(st, s))
        return false;
    if (s->outcome != STORE_NEW)
        return true;
    sqlite3_stmt *in = st->insert;
    if (s->join && !interest(st, st->join, r->id, r->owner))
        return false;
    store_bind_text(in, 1, r->id);
    sqlite3_bind_int64(in, 3, r->created);
    sqlite3_bind_blob64(in, 4, op->text.at, op->text.len, SQLITE_STATIC);
    store_bind_sum(in, 5, r->id, op->text);
    store_bind_text(in, 6, r->owner);
    sqlite3_bind_int64(in, 7, r->seconds);
    sqlite3_bind_int64(in, 8, r->epoch ? r->epoch : store_epoch(&st->face));
    return store_step(in);
}

/* A statement that is needed rarely: texts and numbers in their order, a NULL text left out. */
static bool change(struct lite *st, const char *sql, const char *one, const char *two, int64_t three, int64_t four)
{
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(st->queue, sql, -1, &s, NULL) == SQLITE_OK;
    int count = ok ? sqlite3_bind_parameter_count(s) : 0;
    assert(count <= 4);
    if (count >= 1)
        store_bind_text(s, 1, one);
    if (count >= 2)
        store_bind_text(s, 2, two);
    if (count >= 3)
        sqlite3_bind_int64(s, 3, three);
    if (count >= 4)
        sqlite3_bind_int64(s, 4, four);
    ok = ok && sqlite3_step(s) == SQLITE_DONE;
    sqlite3_finalize(s);
    return ok;
}

bool lite_decide_cancel(struct lite *st, struct store_op *op)
{
    struct store_cancel *c = op->what;
    int64_t found[3] = { -1 };
    c->outcome = STORE_UNKNOWN;
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(st->queue, "SELECT status, (SELECT count(*) FROM interests WHERE id = ?1 AND owner = ?2),"
                                            " (SELECT count(*) FROM interests WHERE id = ?1 AND owner <> ?2) FROM jobs WHERE id = ?1", -1, &s, NULL) == SQLITE_OK;
    if (ok) {
        store_bind_text(s, 1, c->id);
        store_bind_text(s, 2, c->owner);
        int rc = sqlite3_step(s);
        ok = rc == SQLITE_ROW || rc == SQLITE_DONE;
        for (int i = 0; rc == SQLITE_ROW && i < 3; i++)
            found[i] = sqlite3_column_int64(s, i);
    }
    sqlite3_finalize(s);
    if (!ok || found[0] < 0)
        return ok;
    if (found[0] >= JOB_DONE) {
        c->outcome = STORE_ENDED;
        return true;
    }
    if (c->owner && !found[1]) {
        c->outcome = STORE_NOT_YOURS;
        return true;
    }
    if (c->owner && found[2]) {
        c->outcome = STORE_WITHDRAWN;
        return change(st, "DELETE FROM interests WHERE id = ?1 AND owner = ?2", c->id, c->owner, 0, 0)
            && change(st, "UPDATE jobs SET owner = (SELECT owner FROM interests WHERE id = ?1 ORDER BY seq LIMIT 1) WHERE id = ?1 AND owner = ?2 AND status = 0",
                      c->id, c->owner, 0, 0);
    }
    if (found[0] == JOB_RUNNING) {
        c->outcome = STORE_ASKED;
        return change(st, "UPDATE jobs SET cancel = 1 WHERE id = ?1", c->id, NULL, 0, 0);
    }
    assert(found[0] == JOB_QUEUED);
    c->outcome = STORE_CANCELLED;
    return change(st, "UPDATE jobs SET status = 4, error = ?2, finished = ?3, epoch = ?4 WHERE id = ?1 AND status = 0", c->id, c->error, c->now, store_epoch(&st->face));
}

/* -- Runs -- */

struct claim { const struct store_claimant *who; char id[ID_LENGTH + 1]; bool found; };

bool lite_decide_claim(struct lite *st, struct store_op *op)
{
    struct claim *c = op->what;
    sqlite3_stmt *s = NULL;
    int64_t most = c->who->workers * c->who->share / 100, now = clock_ms();
    c->found = false;
    bool ok = sqlite3_prepare_v2(st->queue, "SELECT w.owner, (SELECT id FROM jobs WHERE seq = w.first) FROM (SELECT owner, min(seq) AS first FROM jobs WHERE status = 0 GROUP BY owner) w"
                                            " LEFT JOIN turns t ON t.owner = w.owner WHERE w.owner = '' OR (SELECT count(*) FROM jobs WHERE status = 1 AND owner = w.owner) < ?1"
                                            " ORDER BY coalesce(t.served, 0), w.first LIMIT 1", -1, &s, NULL) == SQLITE_OK;
    char owner[ACCOUNT_NAME] = "";
    if (ok) {
        sqlite3_bind_int64(s, 1, most > 1 ? most : 1);
        int rc = sqlite3_step(s);
        ok = rc == SQLITE_ROW || rc == SQLITE_DONE;
        c->found = rc == SQLITE_ROW && sqlite3_column_text(s, 1);
        if (c->found) {
            snprintf(owner, sizeof owner, "%s", (const char *)sqlite3_column_text(s, 0));
            snprintf(c->id, sizeof c->id, "%s", (const char *)sqlite3_column_text(s, 1));
        }
    }
    sqlite3_finalize(s);
    if (!ok || !c->found)
        return ok;
    char sql[300];
    snprintf(sql, sizeof sql, "UPDATE jobs SET status = 1, started = %lld, stage = 'running', fraction = 0, cancel = 0, lease = ?3, epoch = ?4 WHERE id = ?1", (long long)now);
    return change(st, sql, c->id, NULL, now + (int64_t)(1000 * c->who->lease), store_epoch(&st->face))
        && change(st, "INSERT OR REPLACE INTO turns VALUES(?1, (SELECT coalesce(max(served), 0) + 1 FROM turns))", owner, NULL, 0, 0);
}

struct beats { struct store_beat *beat; int count; double lease; };

bool lite_decide_beat(struct lite *st, struct store_op *op)
{
    struct beats *b = op->what;
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(st->queue, "UPDATE jobs SET lease = ?3, stage = ?4, fraction = ?5 WHERE id = ?1 AND epoch = ?2 AND status = 1 RETURNING cancel", -1, &s, NULL) == SQLITE_OK;
    for (int i = 0; ok && i < b->count; i++) {
        struct store_beat *one = &b->beat[i];
        store_bind_text(s, 1, one->id);
        sqlite3_bind_int64(s, 2, one->epoch);
        sqlite3_bind_int64(s, 3, clock_ms() + (int64_t)(1000 * b->lease));
        store_bind_text(s, 4, one->progress.stage);
        sqlite3_bind_double(s, 5, one->progress.fraction);
        int rc = sqlite3_step(s);
        one->answer = rc != SQLITE_ROW ? BEAT_LOST : sqlite3_column_int(s, 0) ? BEAT_CANCEL : BEAT_HELD;
        ok = rc == SQLITE_ROW || rc == SQLITE_DONE;
        sqlite3_reset(s);
    }
    sqlite3_finalize(s);
    return ok;
}

bool lite_decide_reap(struct lite *st, struct store_op *op)
{
    struct store_reaping *r = op->what;
    char sql[500];
    /* One that is cancelled ends; one that was tried too often fails; the others wait again. */
    snprintf(sql, sizeof sql, "UPDATE jobs SET status = CASE WHEN cancel THEN 4 WHEN attempts + 1 >= %d THEN 3 ELSE 0 END, attempts = attempts + 1, lease = 0, epoch = ?4,"
                              " finished = CASE WHEN cancel OR attempts + 1 >= %d THEN ?3 ELSE 0 END, error = CASE WHEN cancel THEN ?2 WHEN attempts + 1 >= %d THEN ?1 END,"
                              " started = 0 WHERE status = 1 AND lease > 0 AND lease < %lld", r->tries, r->tries, r->tries, (long long)clock_ms());
    bool ok = change(st, sql, r->died, r->cancelled, r->now, store_epoch(&st->face));
    r->count = ok ? sqlite3_changes(st->queue) : 0;
    return ok;
}

/* -- Waiting for the transaction -- */

struct turn { sem_t over; enum store_kept how; };

static void over(void *ctx, enum store_kept how)
{
    struct turn *t = ctx;
    t->how = how;
    sem_post(&t->over);
}

static bool decide(struct lite *st, enum store_op_kind kind, void *what)
{
    struct turn t = { .how = STORE_LOST };
    assert(!pthread_equal(pthread_self(), st->queue_writer.thread));      /* it would wait for itself */
    sem_init(&t.over, 0, 0);
    if (lite_submit(st, (struct store_op){ .kind = kind, .what = what, .done = over, .ctx = &t }))
        while (sem_wait(&t.over) != 0)
            continue;
    sem_destroy(&t.over);
    return t.how == STORE_KEPT;
}

enum store_answer lite_claim(struct store *face, const struct store_claimant *who, struct job_row *row, char **request, size_t *length)
{
    struct claim c = { .who = who };
    if (!decide(lite_of(face), OP_CLAIM, &c))
        return STORE_BROKEN;
    if (!c.found)
        return STORE_NONE;
    enum store_answer a = lite_job(face, c.id, row);
    return a == STORE_FOUND ? lite_request(face, c.id, request, length) : a;
}

bool lite_beat(struct store *face, const struct store_claimant *who, struct store_beat *beat, int count)
{
    struct beats b = { beat, count, who->lease };
    return decide(lite_of(face), OP_BEAT, &b);
}

bool lite_reap(struct store *face, struct store_reaping *r)
{
    return decide(lite_of(face), OP_REAP, r);
}
