/* The thread that looks after the store: it hears hints and sends ours, finds out when a database
 * that was away is back, and drops results that are too much. */
#include "pg_parts.h"
#include "budget.h"
#include "log.h"
#include "metrics.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const double SECONDS = 5, TURN = 0.05, AGAIN = 0.5, EVICT = 30, DROP_SECONDS = 60;

static void told(struct pg *p)
{
    pthread_mutex_lock(&p->lock);
    p->heard++;
    pthread_cond_broadcast(&p->news);
    pthread_mutex_unlock(&p->lock);
}

static bool command_within(PGconn *c, const char *sql, double seconds)
{
    PGresult *r = pg_run(c, sql, NULL, false, seconds);
    bool ok = r && (PQresultStatus(r) == PGRES_COMMAND_OK || PQresultStatus(r) == PGRES_TUPLES_OK);
    PQclear(r);
    return ok;
}

static bool command(PGconn *c, const char *sql) { return command_within(c, sql, SECONDS); }

static void came_back(struct pg *p)
{
    if (atomic_exchange(&p->down, false))
        log_event(LOG_L_WARN, "database_back", NULL);
}

/* A write that means nothing: what was refused for lack of room, or as the server only reads, may go again. */
static bool writes(PGconn *c)
{
    return command(c, "INSERT INTO daemons VALUES('', '', 0, clock_timestamp()) ON CONFLICT(name) DO UPDATE SET seen = clock_timestamp()");
}

static bool evict(struct pg *p, PGconn *c)
{
    static const char sql[] = "WITH gone AS (DELETE FROM results WHERE $1 < (SELECT sum(bytes) FROM results) AND id IN (SELECT id FROM"
                              " (SELECT id, sum(bytes) OVER (ORDER BY used DESC, id) AS upto FROM results) AS s WHERE upto > $1 / 10 * 9) RETURNING 1)"
                              " SELECT count(*) FROM gone";
    int64_t limit = p->result_limit ? atomic_load(p->result_limit) : 0;
    struct pg_args a = { 0 };
    if (!limit)
        return true;
    pg_number(&a, limit);
    PGresult *r = pg_run(c, sql, &a, false, DROP_SECONDS);
    bool ok = r && PQresultStatus(r) == PGRES_TUPLES_OK;
    if (ok)
        atomic_fetch_add(&p->metrics->counter[METRIC_EVICTED], (unsigned long)pg_int(r, 0, 0));
    PQclear(r);
    return ok;
}

/* Pieces of runs that were fenced, or whose daemon died before it told their end. */
static bool sweep(struct pg *p, PGconn *c)
{
    return p->schema < PG_SCHEMA_PIECES
        || command_within(c, "DELETE FROM pieces WHERE (id, epoch) IN (SELECT id, epoch FROM pieces p WHERE n = 1 AND made < clock_timestamp() - interval '1 hour'"
                      " AND NOT EXISTS(SELECT 1 FROM results r WHERE r.id = p.id AND r.pieces = p.epoch))", DROP_SECONDS);
}

/* Until the connection is lost or the store closes. */
static void keep(struct pg *p, PGconn *c)
{
    double evict_at = sga_now() + EVICT;
    for (bool ok = command(c, "LISTEN sgad"); ok && !atomic_load(&p->stop);) {
        struct pollfd f = { .fd = PQsocket(c), .events = POLLIN };
        bool any = false;
        poll(&f, 1, (int)(1000 * TURN));
        if (!PQconsumeInput(c))
            return;
        for (PGnotify *n; (n = PQnotifies(c)); PQfreemem(n))
            any |= n->be_pid != PQbackendPID(c);
        if (any)
            told(p);
        /* Somebody else found it away: this connection may be as dead, and tells. */
        if (atomic_load(&p->down) && (ok = command(c, "SELECT 1")))
            came_back(p);
        if (ok && atomic_exchange(&p->hinted, false))
            ok = command(c, "NOTIFY sgad");
        if (ok && !atomic_load(&p->healthy) && atomic_exchange(&p->looking, false) && writes(c))
            atomic_store(&p->healthy, true);
        if (ok && sga_now() > evict_at) {
            ok = evict(p, c) && sweep(p, c);
            evict_at = sga_now() + EVICT;
        }
    }
}

static void *work(void *arg)
{
    struct pg *p = arg;
    while (!atomic_load(&p->stop)) {
        char why[512];
        PGconn *c = pg_connect_again(p, why, sizeof why);
        if (c) {
            came_back(p);
            told(p);                     /* whatever was missed */
            keep(p, c);
            PQfinish(c);
        } else {
            pg_went_down(p, why);
        }
        for (double until = sga_now() + AGAIN; sga_now() < until && !atomic_load(&p->stop);)
            usleep(20000);
    }
    return NULL;
}

bool pg_keeper_start(struct pg *p)
{
    return p->keeps = pthread_create(&p->keeper, NULL, work, p) == 0;
}

void pg_keeper_stop(struct pg *p)
{
    atomic_store(&p->stop, true);
    if (p->keeps)
        pthread_join(p->keeper, NULL);
}

void pg_hint(struct store *face)
{
    atomic_store(&pg_of(face)->hinted, true);
}

void pg_listen(struct store *face, double seconds)
{
    struct pg *p = pg_of(face);
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    long ns = until.tv_nsec + (long)((seconds - (double)(long)seconds) * 1e9);
    until.tv_sec += (long)seconds + ns / 1000000000;
    until.tv_nsec = ns % 1000000000;
    pthread_mutex_lock(&p->lock);
    unsigned long known = p->heard;
    while (p->heard == known && pthread_cond_timedwait(&p->news, &p->lock, &until) == 0)
        continue;
    pthread_mutex_unlock(&p->lock);
}
