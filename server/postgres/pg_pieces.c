/* Long results in pieces (schema-3.sql). */
#include "pg_parts.h"
#include "spool.h"

#include <stdlib.h>
#include <string.h>

enum { PIECE = 1 << 20, FIRST = 256 << 10 };
static const double SECONDS = 20;

struct slice pg_pieces_first(const struct pg *p, struct slice text)
{
    return (struct slice){ text.at, text.len < SPOOL_LONG || p->schema < PG_SCHEMA_PIECES ? text.len : FIRST };
}

static bool ask(struct pg *p, const char *sql, const struct pg_args *a)
{
    PGresult *r = pg_ask(p, sql, a, false, SECONDS);
    PQclear(r);
    return r;
}

bool pg_pieces_put(struct pg *p, const char *id, int64_t epoch, struct slice text, unsigned char sum[DIGEST_BYTES], int *count)
{
    size_t at = pg_pieces_first(p, text).len;
    struct digest_run d;
    struct pg_args left = { 0 };
    pg_text(&left, id), pg_number(&left, epoch);
    bool ok = at == text.len || ask(p, "DELETE FROM pieces WHERE id = $1 AND epoch = $2", &left);     /* of a try that was not answered */
    digest_begin(&d, id);
    digest_add(&d, text.at, at);
    for (*count = 0; ok && at < text.len; at += PIECE) {
        struct slice piece = { text.at + at, text.len - at < PIECE ? text.len - at : PIECE };
        struct pg_args a = { 0 };
        pg_text(&a, id), pg_number(&a, epoch), pg_number(&a, ++*count), pg_bytes(&a, piece);
        digest_add(&d, piece.at, piece.len);
        ok = ask(p, "INSERT INTO pieces(id, epoch, n, piece) VALUES($1,$2,$3,$4) ON CONFLICT(id, epoch, n) DO UPDATE SET piece = excluded.piece", &a);
        spool_rest(piece.at, piece.len);
    }
    digest_end(&d, sum);
    return ok;
}

/* The n-th piece to `at`; its length, 0: it is not there, or longer than what is left. -1: no answer. */
static int64_t take(struct pg *p, const char *id, int64_t epoch, int n, char *at, size_t left)
{
    struct pg_args a = { .known = PG_KNOWN_PIECE };
    pg_text(&a, id), pg_number(&a, epoch), pg_number(&a, n);
    PGresult *r = pg_ask(p, "SELECT piece FROM pieces WHERE id = $1 AND epoch = $2 AND n = $3", &a, true, SECONDS);
    size_t length = r && PQntuples(r) == 1 ? (size_t)PQgetlength(r, 0, 0) : 0;
    if (length > left)
        length = 0;
    if (length)
        memcpy(at, PQgetvalue(r, 0, 0), length);
    PQclear(r);
    return r ? (int64_t)length : -1;
}

enum store_answer pg_pieces_get(struct pg *p, const char *id, int64_t epoch, struct digest_run *d, char *at, size_t left)
{
    int64_t length = 1;
    for (int n = 1; left && length > 0; n++) {
        length = take(p, id, epoch, n, at, left);
        if (length <= 0)
            return length < 0 ? STORE_BROKEN : STORE_NONE;
        digest_add(d, at, (size_t)length);
        spool_rest(at, (size_t)length);
        at += length;
        left -= (size_t)length;
    }
    return STORE_FOUND;
}
