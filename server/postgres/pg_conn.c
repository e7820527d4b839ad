/* Connections: none is waited for without a bound. */
#include "pg_parts.h"
#include "budget.h"
#include "log.h"

#include <assert.h>
#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double CONNECT_SECONDS = 5, MAKING_SECONDS = 1;
/* A database that has just gone away is back within that, where only connections broke: the keeper looks twice a second. */
static const double BACK_SECONDS = 1.5;

static void put(struct pg_args *a, const char *value, int length, int format)
{
    assert(a->count < PG_ARGS);
    a->value[a->count] = value;
    a->length[a->count] = length;
    a->format[a->count++] = format;
}

void pg_text(struct pg_args *a, const char *text) { put(a, text, 0, 0); }
void pg_bytes(struct pg_args *a, struct slice bytes) { put(a, bytes.at, (int)bytes.len, 1); }

void pg_number(struct pg_args *a, int64_t n)
{
    snprintf(a->number[a->count], sizeof a->number[0], "%" PRId64, n);
    put(a, a->number[a->count], 0, 0);
}

void pg_real(struct pg_args *a, double x)
{
    snprintf(a->number[a->count], sizeof a->number[0], "%.17g", x);
    put(a, a->number[a->count], 0, 0);
}

int64_t pg_int(const PGresult *r, int row, int column)
{
    return strtoll(PQgetvalue(r, row, column), NULL, 10);
}

static bool ready(PGconn *c, short events, double until)
{
    double left = until - sga_now();
    struct pollfd p = { .fd = PQsocket(c), .events = events };
    int n = left > 0 && p.fd >= 0 ? poll(&p, 1, (int)(1000 * left) + 1) : 0;
    return n > 0 || (n < 0 && errno == EINTR);
}

/* Sends and waits, without ever standing in a system call past the time. */
static PGresult *wait_answer(PGconn *c, double until)
{
    PGresult *last = NULL, *r;
    for (;;) {
        int rest = PQflush(c);
        if (rest < 0 || !PQconsumeInput(c))
            break;
        if (!PQisBusy(c)) {
            if (!(r = PQgetResult(c)))
                return last;
            PQclear(last);
            last = r;
            continue;
        }
        if (!ready(c, (short)(POLLIN | (rest > 0 ? POLLOUT : 0)), until))
            break;
    }
    PQclear(last);
    return NULL;
}

static PGresult *answer_of(PGconn *c, int sent, double seconds)
{
    PGresult *r = sent ? wait_answer(c, sga_now() + seconds) : NULL;
    if (r && PQstatus(c) != CONNECTION_OK) {
        PQclear(r);
        return NULL;
    }
    return r;
}

PGresult *pg_run(PGconn *c, const char *sql, const struct pg_args *a, bool binary, double seconds)
{
    PQsetnonblocking(c, 1);
    return answer_of(c, PQsendQueryParams(c, sql, a ? a->count : 0, NULL, a ? a->value : NULL, a ? a->length : NULL, a ? a->format : NULL, binary), seconds);
}

/* One that is prepared, on this connection of the pool once. */
static PGresult *run_known(struct pg *p, int i, const char *sql, const struct pg_args *a, bool binary, double seconds)
{
    PGconn *c = p->conn[i];
    char name[16];
    double until = sga_now() + seconds;
    assert(a->known > PG_NOT_KNOWN && (size_t)a->known < 8 * sizeof p->known[i] && p->busy[i]);
    snprintf(name, sizeof name, "known%d", (int)a->known);
    PQsetnonblocking(c, 1);
    if (!(p->known[i] >> a->known & 1)) {
        PGresult *r = answer_of(c, PQsendPrepare(c, name, sql, 0, NULL), seconds);
        if (PQresultStatus(r) != PGRES_COMMAND_OK)
            return r;                   /* an error, or nothing: as of the statement itself */
        PQclear(r);
        p->known[i] |= 1u << a->known;
    }
    return answer_of(c, PQsendQueryPrepared(c, name, a->count, a->value, a->length, a->format, binary), until - sga_now());
}

/* What the address does not say itself. A server that only reads, as a standby does, is passed over. */
PGconn *pg_connect(const char *address, char *why, size_t size)
{
    static const char *const names[] = { "connect_timeout", "target_session_attrs", "tcp_user_timeout", "fallback_application_name", "client_encoding", "dbname", NULL };
    const char *const values[] = { "3", "read-write", "10000", "sgad", "UTF8", address, NULL };
    PGconn *c = PQconnectdbParams(names, values, 1);
    if (c && PQstatus(c) == CONNECTION_OK) {
        PGresult *r = pg_run(c, "SELECT set_config('search_path', 'sgad, pg_catalog', false), set_config('client_min_messages', 'error', false),"
                                " set_config('statement_timeout', '120s', false)", NULL, false, CONNECT_SECONDS);
        bool ok = r && PQresultStatus(r) == PGRES_TUPLES_OK;
        PQclear(r);
        if (ok)
            return c;
    }
    snprintf(why, size, "the database cannot be used: %s", c ? PQerrorMessage(c) : "out of memory");
    for (size_t n = strlen(why); n && why[n - 1] == '\n'; n--)
        why[n - 1] = 0;
    PQfinish(c);
    return NULL;
}

PGconn *pg_connect_again(struct pg *p, char *why, size_t size)
{
    static const double pause[] = { 0.02, 0.2 };
    enum { PAUSES = sizeof pause / sizeof *pause };
    double began = sga_now();
    for (int tries = 0;; tries++) {
        PGconn *c = pg_connect(p->address, why, size);
        if (c || tries == PAUSES || sga_now() - began > MAKING_SECONDS || atomic_load(&p->down) || atomic_load(&p->stop))
            return c;
        usleep((useconds_t)(1e6 * pause[tries]));
    }
}

/* -- The pool -- */

/* Until the database is back, or has been away for so long that nobody waits for it. */
static void wait_until_back(struct pg *p)
{
    while (atomic_load(&p->down) && !atomic_load(&p->stop) && sga_now() < atomic_load(&p->down_since) + BACK_SECONDS)
        usleep(10000);
}

static int borrow(struct pg *p)
{
    int found = -1;
    wait_until_back(p);
    pthread_mutex_lock(&p->lock);
    while (found < 0 && !atomic_load(&p->down)) {
        for (int i = 0; i < PG_POOL && found < 0; i++)
            if (!p->busy[i])
                found = i;
        if (found < 0)
            pthread_cond_wait(&p->free, &p->lock);
    }
    if (found >= 0)
        p->busy[found] = true;
    pthread_mutex_unlock(&p->lock);
    return found;
}

static void give_back(struct pg *p, int i)
{
    pthread_mutex_lock(&p->lock);
    assert(p->busy[i]);
    p->busy[i] = false;
    pthread_cond_signal(&p->free);
    pthread_mutex_unlock(&p->lock);
}

void pg_went_down(struct pg *p, const char *why)
{
    if (!atomic_load(&p->down))
        atomic_store(&p->down_since, sga_now());
    if (!atomic_exchange(&p->down, true))
        log_event(LOG_L_ERROR, "database_away", "reason", why, NULL);
    pthread_mutex_lock(&p->lock);
    pthread_cond_broadcast(&p->free);
    pthread_mutex_unlock(&p->lock);
}

static bool connected(struct pg *p, int i)
{
    enum { ROUNDS = 2 };
    char why[512];
    if (p->conn[i])
        return true;
    p->known[i] = 0;
    for (int rounds = 0; !(p->conn[i] = pg_connect_again(p, why, sizeof why)); rounds++) {
        pg_went_down(p, why);
        wait_until_back(p);
        if (atomic_load(&p->down) || rounds == ROUNDS)
            return false;
    }
    return true;
}

/* Errors that say: not now, or not on this connection. */
static bool passing(const PGresult *r)
{
    const char *state = PQresultErrorField(r, PG_DIAG_SQLSTATE);
    return !state || strncmp(state, "40", 2) == 0 || strncmp(state, "57P", 3) == 0 || strncmp(state, "08", 2) == 0 || strcmp(state, "25006") == 0;
}

PGresult *pg_ask(struct pg *p, const char *sql, const struct pg_args *a, bool binary, double seconds)
{
    int i = borrow(p);
    PGresult *r = NULL;
    if (i < 0)
        return NULL;
    double until = sga_now() + seconds;
    for (int tries = 0; tries < 3 && sga_now() < until && connected(p, i); tries++) {
        PQclear(r);
        r = a && a->known ? run_known(p, i, sql, a, binary, until - sga_now()) : pg_run(p->conn[i], sql, a, binary, until - sga_now());
        ExecStatusType s = PQresultStatus(r);
        if (r && (s == PGRES_TUPLES_OK || s == PGRES_COMMAND_OK))
            break;
        bool again = !r || passing(r);
        if (!again) {
            log_event(LOG_L_ERROR, "database_refused", "reason", PQresultErrorMessage(r), NULL);
            PQclear(r);
            r = NULL;
            break;
        }
        const char *state = r ? PQresultErrorField(r, PG_DIAG_SQLSTATE) : NULL;
        if (!state || strncmp(state, "40", 2) != 0) {      /* of no use any more; after a deadlock it is */
            PQfinish(p->conn[i]);
            p->conn[i] = NULL;
        }
        if (sga_now() >= until)
            pg_went_down(p, "it does not answer");
    }
    ExecStatusType s = PQresultStatus(r);
    if (r && s != PGRES_TUPLES_OK && s != PGRES_COMMAND_OK) {
        PQclear(r);
        r = NULL;
    }
    give_back(p, i);
    return r;
}

void pg_pool_close(struct pg *p)
{
    for (int i = 0; i < PG_POOL; i++)
        PQfinish(p->conn[i]);
}
