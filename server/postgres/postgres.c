/* The life of the shared store, and the tokens beside it. */
#include "postgres.h"
#include "pg_parts.h"
#include "log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool postgres_address(const char *place)
{
    return strncmp(place, "postgresql://", 13) == 0 || strncmp(place, "postgres://", 11) == 0;
}

static void pg_limit(struct store *face, const atomic_long *bytes) { pg_of(face)->result_limit = bytes; }
static bool pg_healthy(struct store *face) { return !atomic_load(&pg_of(face)->down) && atomic_load(&pg_of(face)->healthy); }
static void pg_probe(struct store *face) { atomic_store(&pg_of(face)->looking, true); }
static void pg_look(struct store *face) { (void)face; }

/* The disk is the database's: nothing of it is known here. */
static unsigned long long pg_free_bytes(struct store *face)
{
    (void)face;
    return 0;
}

static unsigned long long pg_disk_bytes(struct store *face, bool results)
{
    (void)face;
    (void)results;
    return 0;
}

static void pg_close(struct store *face)
{
    struct pg *p = pg_of(face);
    pg_hands_stop(p);
    pg_keeper_stop(p);
    pg_pool_close(p);
    pthread_cond_destroy(&p->free);
    pthread_cond_destroy(&p->news);
    pthread_mutex_destroy(&p->lock);
    free(p->address);
    free(p);
}

static const struct store_ops ops = {
    .shared = true, .close = pg_close, .limit = pg_limit, .healthy = pg_healthy, .free_bytes = pg_free_bytes, .bytes = pg_disk_bytes, .probe = pg_probe, .look = pg_look, .touch = pg_touch,
    .submit = pg_submit, .end = pg_end, .release = pg_release, .cancel = pg_cancel, .join = pg_join, .note = pg_note,
    .withdraw = pg_withdraw, .forget = pg_forget, .prune = pg_prune, .barrier = pg_barrier,
    .claim = pg_claim, .beat = pg_beat, .reap = pg_reap, .look_at = pg_look_at,
    .job = pg_job, .request = pg_request, .result = pg_result, .owners = pg_owners, .owned = pg_owned, .list = pg_list,
    .hint = pg_hint, .listen = pg_listen,
};

/* A 202 outlives the loss of a server only where another one has it. */
static void warn_of_standby(PGconn *c)
{
    PGresult *r = PQexec(c, "SELECT current_setting('synchronous_standby_names') <> '', current_setting('synchronous_commit') IN ('on', 'remote_apply'),"
                            " current_setting('fsync')");
    bool ok = PQresultStatus(r) == PGRES_TUPLES_OK;
    if (ok && *PQgetvalue(r, 0, 0) != 't')
        log_event(LOG_L_WARN, "no_synchronous_standby", "meaning", "accepted jobs may be lost with the database server: set synchronous_standby_names", NULL);
    if (ok && (*PQgetvalue(r, 0, 1) != 't' || strcmp(PQgetvalue(r, 0, 2), "on") != 0))
        log_event(LOG_L_WARN, "commits_not_durable", "meaning", "accepted jobs may be lost: set synchronous_commit and fsync to on", NULL);
    PQclear(r);
}

/* The schema of the database; 0 with why: it cannot be used. */
static int speaks(const char *address, char *why, size_t size)
{
    PGconn *c = pg_connect(address, why, size);
    if (!c)
        return 0;
    int version = pg_schema(c);
    bool ok = version >= PG_SCHEMA_LEAST && version <= PG_SCHEMA;
    if (!ok)
        snprintf(why, size, version == 0 ? "the database has no tables of sgad yet: run sgad migrate --store ADDRESS"
                 : version > 0 && version < PG_SCHEMA_LEAST ? "the database has the schema %d of an older sgad: run sgad migrate --store ADDRESS"
                 : version > 0 ? "the database has the schema %d of a newer sgad" : "the schema cannot be read", version);
    else
        warn_of_standby(c);
    PQfinish(c);
    return ok ? version : 0;
}

struct store *postgres_open(const char *address, const char *version, struct metrics *m, char *why, size_t size)
{
    int schema = speaks(address, why, size);
    struct pg *p = schema ? calloc(1, sizeof *p) : NULL;
    if (!p)
        return NULL;
    p->schema = schema;
    p->face.ops = &ops;
    p->version = version;
    p->metrics = m;
    atomic_init(&p->healthy, true);
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->free, NULL);
    pthread_cond_init(&p->news, NULL);
    if ((p->address = strdup(address)) && pg_hands_start(p) && pg_keeper_start(p))
        return &p->face;
    snprintf(why, size, "out of memory");
    pg_close(&p->face);
    return NULL;
}

/* -- Tokens -- */

#define TOKEN "name, encode(sum, 'hex'), scopes, created, expires, revoked, jobs, bytes, waiters, seconds"

/* NULL with the reason. */
static PGresult *token_ask(const char *address, const char *sql, const struct pg_args *a, char *why, size_t size)
{
    PGconn *c = pg_connect(address, why, size);
    if (!c)
        return NULL;
    PGresult *r = pg_run(c, sql, a, false, 5);
    if (r && PQresultStatus(r) != PGRES_TUPLES_OK) {
        snprintf(why, size, "%s", PQresultErrorMessage(r));
        PQclear(r);
        r = NULL;
    } else if (!r) {
        snprintf(why, size, "the database does not answer");
    }
    PQfinish(c);
    return r;
}

bool postgres_tokens(const char *address, void (*each)(void *ctx, const char *const column[10]), void *ctx, char *why, size_t size)
{
    PGresult *r = token_ask(address, "SELECT " TOKEN " FROM tokens ORDER BY created, name", NULL, why, size);
    for (int i = 0; r && i < PQntuples(r); i++) {
        const char *column[10];
        for (int k = 0; k < 10; k++)
            column[k] = PQgetvalue(r, i, k);
        each(ctx, column);
    }
    PQclear(r);
    return r;
}

bool postgres_token_add(const char *address, const char *const column[10], bool *done, char *why, size_t size)
{
    struct pg_args a = { 0 };
    for (int k = 0; k < 10; k++)
        pg_text(&a, column[k]);
    PGresult *r = token_ask(address, "INSERT INTO tokens VALUES($1, decode($2, 'hex'), $3, $4, $5, $6, $7, $8, $9, $10) ON CONFLICT DO NOTHING RETURNING 1", &a, why, size);
    *done = r && PQntuples(r) == 1;
    PQclear(r);
    return r;
}

bool postgres_token_revoke(const char *address, const char *name, long long now, bool *done, char *why, size_t size)
{
    struct pg_args a = { 0 };
    pg_text(&a, name), pg_number(&a, now);
    PGresult *r = token_ask(address, "UPDATE tokens SET revoked = $2 WHERE name = $1 AND revoked = 0 RETURNING 1", &a, why, size);
    *done = r && PQntuples(r) == 1;
    PQclear(r);
    return r;
}
