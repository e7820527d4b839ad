/* Long results in pieces, in cache.db. Of the store, and of commands that read its files. */
#ifndef SERVER_STORE_PIECES_H
#define SERVER_STORE_PIECES_H

#include <sqlite3.h>
#include <stdbool.h>
#include <stddef.h>

#include "json_scan.h"

/* The table and its triggers, where they are missing: an older file has none, and no long results in pieces. */
bool store_pieces_prepare(sqlite3 *db);
/* What of a result stands in its row: all of it, or of a long one the first piece. */
struct slice store_pieces_first(struct slice text);
/* Writes the rest, once that row is there; what it has written rests (spool.h). */
bool store_pieces_put(sqlite3 *db, const char *id, struct slice text);
/* SQL: the bytes of a result that are not in its row. */
#define STORE_PIECES_BYTES(id) "(SELECT coalesce(sum(length(piece)), 0) FROM pieces WHERE pieces.id = " id ")"
/* Is the text of this row (id, text, sum) what was written? pieces: prepared from STORE_PIECES, for what is not in the row, or NULL. */
#define STORE_PIECES "SELECT piece FROM pieces WHERE id = ?1 ORDER BY n"
bool store_pieces_genuine(sqlite3_stmt *row, sqlite3_stmt *pieces);
/* The pieces that are not in the row, in their order. False: one was not taken, or not read. */
bool store_pieces_each(sqlite3_stmt *s, const char *id, bool (*each)(void *ctx, const void *piece, size_t length), void *ctx);

#endif
