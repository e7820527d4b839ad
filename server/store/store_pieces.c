/* Long results: the first piece stands in its row of results, where the verdict is read, the others in a table of their own, so that
 * neither who writes one nor who reads one has all of it in memory. Triggers keep both together, whoever deletes or replaces. */
#include "store_pieces.h"
#include "digest.h"
#include "spool.h"
#include "store_parts.h"

#include <string.h>

enum { PIECE = 256 << 10 };

static size_t first_piece(struct slice text)
{
    return text.len < SPOOL_LONG ? text.len : PIECE;
}

struct slice store_pieces_first(struct slice text)
{
    return (struct slice){ text.at, first_piece(text) };
}

bool store_pieces_prepare(sqlite3 *db)
{
    static const char sql[] =
        "CREATE TABLE IF NOT EXISTS pieces(id TEXT NOT NULL, n INTEGER NOT NULL, piece BLOB NOT NULL, PRIMARY KEY(id, n));"
        "CREATE TRIGGER IF NOT EXISTS result_gone AFTER DELETE ON results BEGIN DELETE FROM pieces WHERE id = old.id; END;"
        "CREATE TRIGGER IF NOT EXISTS result_anew AFTER UPDATE OF result ON results BEGIN DELETE FROM pieces WHERE id = old.id; END;";
    return sqlite3_exec(db, sql, NULL, NULL, NULL) == SQLITE_OK;
}

bool store_pieces_put(sqlite3 *db, const char *id, struct slice text)
{
    size_t at = first_piece(text);
    if (at == text.len)
        return true;
    sqlite3_stmt *s = NULL, *left = NULL;
    /* Some may be there of a row that is not found any more. */
    bool ok = sqlite3_prepare_v2(db, "DELETE FROM pieces WHERE id = ?1", -1, &left, NULL) == SQLITE_OK
        && sqlite3_bind_text(left, 1, id, -1, SQLITE_STATIC) == SQLITE_OK && store_step(left)
        && sqlite3_prepare_v2(db, "INSERT OR REPLACE INTO pieces VALUES(?1, ?2, ?3)", -1, &s, NULL) == SQLITE_OK;
    sqlite3_finalize(left);
    for (int n = 1; ok && at < text.len; n++) {
        size_t length = text.len - at < PIECE ? text.len - at : PIECE;
        sqlite3_bind_text(s, 1, id, -1, SQLITE_STATIC);
        sqlite3_bind_int(s, 2, n);
        sqlite3_bind_blob64(s, 3, text.at + at, length, SQLITE_STATIC);
        ok = store_step(s);
        spool_rest(text.at + at, length);
        at += length;
    }
    sqlite3_finalize(s);
    return ok;
}

bool store_pieces_each(sqlite3_stmt *s, const char *id, bool (*each)(void *ctx, const void *piece, size_t length), void *ctx)
{
    bool ok = sqlite3_bind_text(s, 1, id, -1, SQLITE_STATIC) == SQLITE_OK;
    int rc = SQLITE_DONE;
    while (ok && (rc = sqlite3_step(s)) == SQLITE_ROW)
        ok = each(ctx, sqlite3_column_blob(s, 0), (size_t)sqlite3_column_bytes(s, 0));
    sqlite3_reset(s);
    return ok && rc == SQLITE_DONE;
}

static bool add_piece(void *ctx, const void *piece, size_t length)
{
    digest_add(ctx, piece, length);
    return true;
}

bool store_pieces_genuine(sqlite3_stmt *row, sqlite3_stmt *pieces)
{
    unsigned char sum[DIGEST_BYTES];
    struct digest_run d;
    const char *id = (const char *)sqlite3_column_text(row, 0);
    const void *text = sqlite3_column_blob(row, 1), *kept = sqlite3_column_blob(row, 2);
    digest_begin(&d, id ? id : "");
    digest_add(&d, text, (size_t)sqlite3_column_bytes(row, 1));
    bool whole = !pieces || store_pieces_each(pieces, id ? id : "", add_piece, &d);
    digest_end(&d, sum);
    return whole && kept && sqlite3_column_bytes(row, 2) == sizeof sum && memcmp(kept, sum, sizeof sum) == 0;
}
