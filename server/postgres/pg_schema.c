/* The schema and its steps. A step may only add, so that daemons of the version before go on beside
 * those of the next; what nobody needs any more goes with a later one. */
#include "pg_parts.h"
#include "pg_steps.h"
#include "postgres.h"

#include <stdio.h>
#include <string.h>

static bool command(PGconn *c, const char *sql, char *why, size_t size)
{
    PGresult *r = PQexec(c, sql);
    bool ok = PQresultStatus(r) == PGRES_COMMAND_OK || PQresultStatus(r) == PGRES_TUPLES_OK;
    if (!ok)
        snprintf(why, size, "%s", PQresultErrorMessage(r));
    PQclear(r);
    return ok;
}

int pg_schema(PGconn *c)
{
    int version = -1;
    PGresult *r = PQexec(c, "SELECT to_regclass('sgad.schema') IS NOT NULL");
    bool there = PQresultStatus(r) == PGRES_TUPLES_OK && *PQgetvalue(r, 0, 0) == 't', known = PQresultStatus(r) == PGRES_TUPLES_OK;
    PQclear(r);
    if (!there)
        return known ? 0 : -1;
    r = PQexec(c, "SELECT version FROM sgad.schema");
    if (PQresultStatus(r) == PGRES_TUPLES_OK)
        version = PQntuples(r) == 1 ? (int)pg_int(r, 0, 0) : 0;
    PQclear(r);
    return version;
}

static bool step(PGconn *c, int version, char *why, size_t size)
{
    char set[120];
    snprintf(set, sizeof set, "DELETE FROM sgad.schema; INSERT INTO sgad.schema VALUES(%d)", version);
    bool ok = command(c, "BEGIN", why, size) && (version > 1 || command(c, "CREATE SCHEMA IF NOT EXISTS sgad; CREATE TABLE IF NOT EXISTS sgad.schema(version int NOT NULL)", why, size))
        && command(c, pg_steps[version - 1], why, size) && command(c, set, why, size) && command(c, "COMMIT", why, size);
    if (!ok)
        PQclear(PQexec(c, "ROLLBACK"));
    return ok;
}

bool postgres_migrate(const char *address, int *from, int *to, char *why, size_t size)
{
    PGconn *c = pg_connect(address, why, size);
    bool ok = c && command(c, "SET statement_timeout = 0; SELECT pg_advisory_lock(hashtextextended('sgad migrate', 0))", why, size);
    *from = *to = ok ? pg_schema(c) : -1;
    if (ok && *from < 0) {
        snprintf(why, size, "the schema cannot be read: %s", PQerrorMessage(c));
        ok = false;
    }
    if (ok && *from > PG_SCHEMA) {
        snprintf(why, size, "the database has the schema %d of a newer sgad; this one knows %d", *from, PG_SCHEMA);
        ok = false;
    }
    while (ok && *to < PG_SCHEMA)
        if ((ok = step(c, *to + 1, why, size)))
            ++*to;
    PQfinish(c);
    return ok;
}
