/* Orders, carried out by a few threads: those about one job by one of them, in their order. */
#include "pg_parts.h"
#include "budget.h"
#include "log.h"
#include "metrics.h"
#include "spool.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TOUCHES = 256 };
static const double SECONDS = 10, RESULT_SECONDS = 100, LATELY = 2, TOUCH_SECONDS = 60;      /* the last: as the statement says */

/* Counts the hands that have come to it. */
struct pg_barrier {
    atomic_int left;
    atomic_bool lost;
    store_done *done;
    void *ctx;
};

static unsigned hash(const char *id)
{
    unsigned h = 2166136261u;
    for (; *id; id++)
        h = (h ^ (unsigned char)*id) * 16777619u;
    return h;
}

static struct pg_hand *hand_of(struct pg *p, const char *id)
{
    return &p->hand[hash(id) % PG_HANDS];
}

static void put(struct pg_hand *h, struct pg_order *o)
{
    o->next = NULL;
    pthread_mutex_lock(&h->lock);
    assert(!*h->last);
    *h->last = o;
    h->last = &o->next;
    h->waiting++;
    pthread_cond_signal(&h->work);
    pthread_mutex_unlock(&h->lock);
}

static bool give(struct pg_hand *h, struct pg_order order)
{
    struct pg_order *o = malloc(sizeof *o);
    if (!o)
        return false;
    *o = order;
    put(h, o);
    return true;
}

static void pg_sum(struct pg_args *a, unsigned char sum[DIGEST_BYTES], const char *id, struct slice text)
{
    digest_kept(sum, id, text.at, text.len);
    pg_bytes(a, (struct slice){ (const char *)sum, DIGEST_BYTES });
}

/* The answer of a function that gives one whole number; LOST where there is none. */
static bool number(struct pg *p, const char *sql, const struct pg_args *a, double seconds, int64_t *out)
{
    PGresult *r = pg_ask(p, sql, a, false, seconds);
    bool ok = r && PQntuples(r) == 1;
    if (ok)
        *out = pg_int(r, 0, 0);
    PQclear(r);
    return ok;
}

static bool done(struct pg *p, const char *sql, const struct pg_args *a)
{
    PGresult *r = pg_ask(p, sql, a, false, SECONDS);
    PQclear(r);
    return r;
}

/* The words live as long as the program. */
static const char *known_quota(const char *words)
{
    static const char *const known[] = { "places in the queue", "jobs that wait or run", "bytes of requests that wait" };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(known[i], words) == 0)
            return known[i];
    return "seconds of running in an hour, those that its waiting jobs may need included";
}

static enum store_kept submit(struct pg *p, struct pg_order *o)
{
    struct store_submission *s = o->what;
    const struct store_room *m = &s->room;
    struct pg_args a = { 0 };
    unsigned char sum[DIGEST_BYTES];
    pg_text(&a, s->row.id), pg_text(&a, s->row.owner), pg_text(&a, p->version), pg_number(&a, s->row.created), pg_number(&a, s->row.seconds);
    pg_bytes(&a, s->request), pg_sum(&a, sum, s->row.id, s->request), pg_text(&a, s->join ? "t" : "f"), pg_text(&a, s->again ? "t" : "f");
    pg_number(&a, m->queue), pg_number(&a, m->queue_bytes), pg_number(&a, m->share), pg_number(&a, m->jobs), pg_number(&a, m->bytes), pg_number(&a, m->seconds);
    pg_number(&a, m->used);
    PGresult *r = pg_ask(p, "SELECT outcome, quota, retry FROM submit_1($1,$2,$3,$4,$5,$6,$7,$8,$9,$10,$11,$12,$13,$14,$15,$16)", &a, false, SECONDS);
    if (!r)
        return STORE_LOST;
    s->outcome = (enum store_outcome)pg_int(r, 0, 0);
    s->quota = known_quota(PQgetvalue(r, 0, 1));
    s->retry = pg_int(r, 0, 2);
    PQclear(r);
    return STORE_KEPT;
}

/* The verdict stands first in a result, where the writer of answers puts it. */
static void verdict_of(struct slice result, char *out, size_t size)
{
    static const char begins[] = "{\"verdict\":\"";
    size_t n = sizeof begins - 1, k = 0;
    if (result.at && result.len > n && memcmp(result.at, begins, n) == 0)
        while (n + k < result.len && k + 1 < size && ((result.at[n + k] >= 'a' && result.at[n + k] <= 'z') || result.at[n + k] == '_'))
            k++;
    bool whole = k && n + k < result.len && result.at[n + k] == '"';
    snprintf(out, size, "%.*s", whole ? (int)k : 0, whole ? result.at + n : "");
}

static enum store_kept end(struct pg *p, struct pg_order *o)
{
    struct pg_args a = { 0 };
    unsigned char sum[DIGEST_BYTES];
    char verdict[sizeof o->row.verdict];
    struct slice first = pg_pieces_first(p, o->text);
    bool pieces = p->schema >= PG_SCHEMA_PIECES;
    int64_t how = 0;
    int count = 0;
    verdict_of(o->text, verdict, sizeof verdict);
    if (o->text.at && !pg_pieces_put(p, o->row.id, o->row.epoch, o->text, sum, &count))
        return STORE_LOST;
    pg_text(&a, o->row.id), pg_number(&a, o->row.epoch), pg_number(&a, o->row.status), pg_number(&a, o->row.started), pg_number(&a, o->row.finished);
    pg_text(&a, o->row.error), pg_text(&a, verdict), pg_text(&a, p->version), pg_bytes(&a, first);
    pg_bytes(&a, (struct slice){ o->text.at ? (const char *)sum : NULL, o->text.at ? DIGEST_BYTES : 0 });
    if (pieces)
        pg_number(&a, (int64_t)o->text.len), pg_number(&a, count);
    return number(p, pieces ? "SELECT end_2($1,$2,$3,$4,$5,$6,$7,$8,$9,$10,$11,$12)" : "SELECT end_1($1,$2,$3,$4,$5,$6,$7,$8,$9,$10)", &a,
                  first.len > SPOOL_LONG ? RESULT_SECONDS : SECONDS, &how) ? (enum store_kept)how : STORE_LOST;
}

static enum store_kept release(struct pg *p, struct pg_order *o)
{
    struct pg_args a = { 0 };
    int64_t how = 0;
    pg_text(&a, o->row.id), pg_number(&a, o->row.epoch), pg_number(&a, o->row.attempts), pg_text(&a, o->row.error), pg_number(&a, o->row.finished);
    return number(p, "SELECT release_1($1,$2,$3,$4,$5)", &a, SECONDS, &how) ? (enum store_kept)how : STORE_LOST;
}

static enum store_kept cancel(struct pg *p, struct pg_order *o)
{
    struct store_cancel *c = o->what;
    struct pg_args a = { 0 };
    int64_t outcome = 0;
    pg_text(&a, c->id), pg_text(&a, c->owner), pg_text(&a, c->error), pg_number(&a, c->now);
    if (!number(p, "SELECT cancel_1($1,$2,$3,$4)", &a, SECONDS, &outcome))
        return STORE_LOST;
    c->outcome = (enum store_cancelled)outcome;
    return STORE_KEPT;
}

/* Jobs that are in `old`, with their results. */
#define JOBS_GONE(old) "WITH gone AS (DELETE FROM jobs WHERE id IN (" old ") RETURNING id), r AS (DELETE FROM results WHERE id IN (SELECT id FROM gone)) SELECT count(*) FROM gone"
#define RESULTS_GONE(old) "WITH gone AS (DELETE FROM results WHERE id IN (" old ") RETURNING id) SELECT count(*) FROM gone"

static bool prune(struct pg *p, const struct store_keep *k)
{
    const struct { int64_t bound; enum metrics_counter counted; const char *sql; } by[] = {
        { k->since, METRIC_PRUNED, JOBS_GONE("SELECT id FROM jobs WHERE status >= 2 AND finished < $1 ORDER BY finished LIMIT 1000 FOR UPDATE SKIP LOCKED") },
        { k->jobs, METRIC_PRUNED, JOBS_GONE("SELECT id FROM jobs WHERE status >= 2 ORDER BY finished DESC LIMIT 1000 OFFSET $1") },
        { k->bytes, METRIC_PRUNED, JOBS_GONE("SELECT id FROM (SELECT id, sum(bytes) OVER (ORDER BY finished, id) - bytes AS before FROM (SELECT id, finished, bytes FROM jobs"
                                             " WHERE status >= 2 ORDER BY finished LIMIT 1000) o) s WHERE before < (SELECT sum(bytes) FROM jobs WHERE status >= 2) - $1") },
        { k->results_since, METRIC_EVICTED, RESULTS_GONE("SELECT id FROM results WHERE made < $1 ORDER BY made LIMIT 1000 FOR UPDATE SKIP LOCKED") },
        { k->results, METRIC_EVICTED, RESULTS_GONE("SELECT id FROM results ORDER BY made DESC LIMIT 1000 OFFSET $1") },
    };
    bool ok = true;
    for (size_t i = 0; i < sizeof by / sizeof *by; i++) {
        struct pg_args a = { 0 };
        int64_t gone = 0;
        if (!by[i].bound)
            continue;
        pg_number(&a, by[i].bound);
        ok &= number(p, by[i].sql, &a, SECONDS, &gone);
        atomic_fetch_add(&p->metrics->counter[by[i].counted], (unsigned long)gone);
    }
    return ok;
}

static bool interest(struct pg *p, const struct pg_order *o)
{
    struct pg_args a = { 0 };
    pg_text(&a, o->row.id);
    switch (o->kind) {
    case PG_JOIN:
        pg_text(&a, o->row.owner);
        return done(p, "INSERT INTO interests(id, owner, status) SELECT id, $2, status FROM jobs WHERE id = $1 ON CONFLICT(id, owner)"
                       " DO UPDATE SET seq = nextval(pg_get_serial_sequence('interests', 'seq'))", &a);
    case PG_NOTE:
        pg_text(&a, o->row.owner);
        return done(p, "INSERT INTO interests(id, owner, status) SELECT id, $2, status FROM jobs WHERE id = $1 ON CONFLICT DO NOTHING", &a);
    case PG_WITHDRAW:
        pg_text(&a, o->row.owner);
        return done(p, "DELETE FROM interests WHERE id = $1 AND owner = $2", &a);
    case PG_TOUCH:
        return done(p, "UPDATE results SET used = clock_timestamp() WHERE id = $1 AND used < clock_timestamp() - interval '1 minute'", &a);
    default:
        return done(p, "WITH gone AS (DELETE FROM jobs WHERE id = $1 AND status >= 2 RETURNING id) DELETE FROM results WHERE id IN (SELECT id FROM gone)", &a);
    }
}

static void arrive(struct pg_hand *h, struct pg_barrier *b)
{
    if (sga_now() - h->lost < LATELY || atomic_load(&h->pg->down))
        atomic_store(&b->lost, true);
    int left = atomic_fetch_sub(&b->left, 1);
    assert(left > 0 && left <= PG_HANDS);
    if (left != 1)
        return;
    b->done(b->ctx, atomic_load(&b->lost) ? STORE_LOST : STORE_KEPT);
    free(b);
}

static enum store_kept carry_out(struct pg *p, struct pg_order *o)
{
    switch (o->kind) {
    case PG_SUBMIT: return submit(p, o);
    case PG_END: return end(p, o);
    case PG_RELEASE: return release(p, o);
    case PG_CANCEL: return cancel(p, o);
    case PG_PRUNE: return prune(p, &o->keep) ? STORE_KEPT : STORE_LOST;
    default: return interest(p, o) ? STORE_KEPT : STORE_LOST;
    }
}

static void *work(void *arg)
{
    struct pg_hand *h = arg;
    for (;;) {
        pthread_mutex_lock(&h->lock);
        while (!h->first && !h->stop)
            pthread_cond_wait(&h->work, &h->lock);
        struct pg_order *o = h->first;
        if (o && !(h->first = o->next))
            h->last = &h->first;
        h->waiting -= o != NULL;
        assert(h->waiting >= 0 && (o || h->waiting == 0));
        pthread_mutex_unlock(&h->lock);
        if (!o)
            return NULL;
        if (o->kind == PG_BARRIER) {
            arrive(h, o->barrier);
        } else {
            double began = sga_now();
            enum store_kept how = carry_out(h->pg, o);
            metrics_committed(h->pg->metrics, sga_now() - began);
            metrics_add(h->pg->metrics, how == STORE_LOST ? METRIC_STORE_FAILURES : METRIC_STORE_COMMITS);
            if (how == STORE_LOST && o->kind != PG_TOUCH) {
                h->lost = o->done ? h->lost : sga_now();
                atomic_store(&h->pg->healthy, false);
            }
            if (o->done)
                o->done(o->ctx, how);
        }
        free(o);
    }
}

bool pg_hands_start(struct pg *p)
{
    for (int i = 0; i < PG_HANDS; i++) {
        struct pg_hand *h = &p->hand[i];
        h->pg = p;
        h->last = &h->first;
        h->lost = -LATELY;
        pthread_mutex_init(&h->lock, NULL);
        pthread_cond_init(&h->work, NULL);
        if (!(h->runs = pthread_create(&h->thread, NULL, work, h) == 0))
            return false;
    }
    return true;
}

void pg_hands_stop(struct pg *p)
{
    for (int i = 0; i < PG_HANDS; i++) {
        struct pg_hand *h = &p->hand[i];
        if (!h->runs)
            continue;
        pthread_mutex_lock(&h->lock);
        h->stop = true;
        pthread_cond_signal(&h->work);
        pthread_mutex_unlock(&h->lock);
        pthread_join(h->thread, NULL);
    }
}

/* -- What is given -- */

bool pg_submit(struct store *face, struct store_submission *s, store_done *over, void *ctx)
{
    return give(hand_of(pg_of(face), s->row.id), (struct pg_order){ .kind = PG_SUBMIT, .what = s, .done = over, .ctx = ctx });
}

bool pg_end(struct store *face, const struct job_row *row, struct slice result, store_done *over, void *ctx)
{
    return give(hand_of(pg_of(face), row->id), (struct pg_order){ .kind = PG_END, .row = *row, .text = result, .done = over, .ctx = ctx });
}

bool pg_release(struct store *face, const struct job_row *row, int64_t *next, store_done *over, void *ctx)
{
    (void)next;
    return give(hand_of(pg_of(face), row->id), (struct pg_order){ .kind = PG_RELEASE, .row = *row, .done = over, .ctx = ctx });
}

bool pg_cancel(struct store *face, struct store_cancel *c, store_done *over, void *ctx)
{
    return give(hand_of(pg_of(face), c->id), (struct pg_order){ .kind = PG_CANCEL, .what = c, .done = over, .ctx = ctx });
}

static bool give_interest(struct store *face, enum pg_kind kind, const char *id, const char *owner)
{
    struct pg_order o = { .kind = kind };
    snprintf(o.row.id, sizeof o.row.id, "%s", id);
    snprintf(o.row.owner, sizeof o.row.owner, "%s", owner);
    return give(hand_of(pg_of(face), id), o);
}

bool pg_join(struct store *face, const char *id, const char *owner) { return give_interest(face, PG_JOIN, id, owner); }
bool pg_note(struct store *face, const char *id, const char *owner) { return give_interest(face, PG_NOTE, id, owner); }
bool pg_withdraw(struct store *face, const char *id, const char *owner) { return give_interest(face, PG_WITHDRAW, id, owner); }
bool pg_forget(struct store *face, const char *id) { return give_interest(face, PG_FORGET, id, ""); }

void pg_touch(struct store *face, const char *id, int64_t now)
{
    struct pg_hand *h = hand_of(pg_of(face), id);
    int at = (int)(hash(id) / PG_HANDS % PG_TOUCHED);
    double moment = sga_now();
    (void)now;
    pthread_mutex_lock(&h->lock);
    bool told = strcmp(h->touched[at].id, id) == 0 && moment - h->touched[at].at < TOUCH_SECONDS, room = h->waiting < TOUCHES && !told;
    if (room) {
        snprintf(h->touched[at].id, sizeof h->touched[at].id, "%s", id);
        h->touched[at].at = moment;
    }
    pthread_mutex_unlock(&h->lock);
    if (room)
        give_interest(face, PG_TOUCH, id, "");
}

bool pg_prune(struct store *face, const struct store_keep *keep)
{
    return give(&pg_of(face)->hand[0], (struct pg_order){ .kind = PG_PRUNE, .keep = *keep });
}

bool pg_barrier(struct store *face, store_done *over, void *ctx)
{
    struct pg *p = pg_of(face);
    struct pg_barrier *b = calloc(1, sizeof *b);
    struct pg_order *o[PG_HANDS];
    bool ok = b;
    for (int i = 0; i < PG_HANDS; i++)
        ok &= (o[i] = calloc(1, sizeof *o[i])) != NULL;
    if (!ok) {                         /* for all of them or for none */
        for (int i = 0; i < PG_HANDS; i++)
            free(o[i]);
        free(b);
        return false;
    }
    b->done = over;
    b->ctx = ctx;
    atomic_init(&b->left, PG_HANDS);
    for (int i = 0; i < PG_HANDS; i++) {
        o[i]->kind = PG_BARRIER;
        o[i]->barrier = b;
        put(&p->hand[i], o[i]);
    }
    return true;
}
