/* Keeping the results within their share of the disk, their age and their number: of the disk the least recently used go first, down
 * to nine tenths of the limit, so that not every new result costs a search. The disk has a share too: results leave a part of it free. When a result was
 * last read is in a table of its own: to change a row of results would rewrite its text. */
#include "store_parts.h"
#include "log.h"
#include "metrics.h"

#include <assert.h>
#include <stdio.h>

static int64_t number(sqlite3 *db, const char *sql)
{
    sqlite3_stmt *s = NULL;
    int64_t value = -1;
    if (sqlite3_prepare_v2(db, sql, -1, &s, NULL) == SQLITE_OK && sqlite3_step(s) == SQLITE_ROW)
        value = sqlite3_column_int64(s, 0);
    sqlite3_finalize(s);
    return value;
}

int64_t store_bytes_used(sqlite3 *db)
{
    int64_t pages = number(db, "PRAGMA page_count"), unused = number(db, "PRAGMA freelist_count"), size = number(db, "PRAGMA page_size");
    return pages < 0 || unused < 0 || size < 0 ? -1 : (pages - unused) * size;
}

bool store_evict_prepare(struct lite *st)
{
    static const char sql[] = "CREATE TABLE IF NOT EXISTS used(id TEXT PRIMARY KEY, at INTEGER NOT NULL) WITHOUT ROWID;"
                              "CREATE INDEX IF NOT EXISTS results_by_age ON results(made)";
    return sqlite3_exec(st->cache, sql, NULL, NULL, NULL) == SQLITE_OK;
}

bool store_evict_touch(struct lite *st, const struct job_row *row)
{
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(st->cache, "INSERT OR REPLACE INTO used VALUES(?1, ?2)", -1, &s, NULL) == SQLITE_OK
        && sqlite3_bind_text(s, 1, row->id, -1, SQLITE_STATIC) == SQLITE_OK
        && sqlite3_bind_int64(s, 2, row->finished) == SQLITE_OK && sqlite3_step(s) == SQLITE_DONE;
    sqlite3_finalize(s);
    return ok;
}

/* The oldest uses first, with running sums of the texts' lengths: all that lie before the
 * point where enough is freed. */
static bool drop_oldest(sqlite3 *db, int64_t excess)
{
    static const char sql[] =
        "DELETE FROM results WHERE id IN (SELECT id FROM (SELECT id, sum(bytes) OVER (ORDER BY at, id) - bytes AS before FROM"
        " (SELECT r.id AS id, coalesce(u.at, r.made) AS at, length(r.result) + " STORE_PIECES_BYTES("r.id") " AS bytes"
        " FROM results r LEFT JOIN used u ON u.id = r.id)) WHERE before < ?1)";
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_exec(db, "BEGIN IMMEDIATE", NULL, NULL, NULL) == SQLITE_OK
        && sqlite3_prepare_v2(db, sql, -1, &s, NULL) == SQLITE_OK && sqlite3_bind_int64(s, 1, excess) == SQLITE_OK && sqlite3_step(s) == SQLITE_DONE;
    sqlite3_finalize(s);
    ok = ok && sqlite3_exec(db, "DELETE FROM used WHERE id NOT IN (SELECT id FROM results)", NULL, NULL, NULL) == SQLITE_OK
        && sqlite3_exec(db, "COMMIT", NULL, NULL, NULL) == SQLITE_OK;
    if (!ok && !sqlite3_get_autocommit(db))
        sqlite3_exec(db, "ROLLBACK", NULL, NULL, NULL);
    return ok;
}

static void tell(struct lite *st, bool ok, int64_t gone, const char *reason)
{
    char count[32];
    snprintf(count, sizeof count, "%lld", (long long)gone);
    if (gone > 0)
        atomic_fetch_add(&st->metrics->counter[METRIC_EVICTED], (unsigned long)gone);
    log_event(ok ? LOG_L_INFO : LOG_L_WARN, "results_evicted", "#count", count, "reason", ok ? NULL : reason, NULL);
}

/* Of so many bytes, with those that the disk or the limit calls for. */
static bool evict(struct lite *st, int64_t excess)
{
    assert(excess >= 0);                     /* a window of a negative one would hold nothing */
    int64_t before = number(st->cache, "SELECT count(*) FROM results");
    if (before <= 0)
        return false;
    bool ok = drop_oldest(st->cache, excess);
    char reason[200];
    snprintf(reason, sizeof reason, "%s", sqlite3_errmsg(st->cache));
    int64_t gone = before - number(st->cache, "SELECT count(*) FROM results");
    tell(st, ok, gone, reason);
    return ok && gone > 0;
}

/* Bytes that results give up for the disk's sake, beside the new ones of so many bytes: those take the place of older ones where the
 * file could not grow and leave the disk its spare. Pages that are free in the file do as well; those that are in its log only are yet
 * to be written to it. Where results hold less than the spare, others fill the disk, and what results could give up would not help. */
static int64_t short_of_disk(const struct lite *st, int64_t bytes)
{
    int64_t pages = number(st->cache, "PRAGMA page_count"), unused = number(st->cache, "PRAGMA freelist_count"), size = number(st->cache, "PRAGMA page_size");
    int64_t file = (int64_t)store_place_size(st->folder, "cache.db"), spare = (int64_t)store_place_spare(st->folder);
    if (pages < 0 || unused < 0 || size < 0 || (pages - unused) * size < spare)
        return 0;
    int64_t growth = pages * size > file ? pages * size - file : 0;
    int64_t room = (int64_t)store_place_free(st->folder) - growth - spare;
    return room > 0 || unused * size >= 2 * bytes ? 0 : 2 * bytes - unused * size;
}

void store_evict(struct lite *st, int64_t bytes)
{
    int64_t limit = st->cache_limit ? atomic_load(st->cache_limit) : 0, used = store_bytes_used(st->cache), excess = short_of_disk(st, bytes);
    if (excess > 0)
        excess += used / 20;                /* not with every new one */
    if (limit && used > limit && used - limit / 10 * 9 > excess)
        excess = used - limit / 10 * 9;
    if (excess > 0)
        evict(st, excess);
}

bool store_evict_for(struct lite *st, int64_t bytes)
{
    if (store_bytes_used(st->cache) < (int64_t)store_place_spare(st->folder))
        return false;
    sqlite3_wal_checkpoint_v2(st->cache, NULL, SQLITE_CHECKPOINT_PASSIVE, NULL, NULL);      /* what it has written is room in its log */
    bool ok = evict(st, 2 * bytes);
    sqlite3_wal_checkpoint_v2(st->cache, NULL, SQLITE_CHECKPOINT_PASSIVE, NULL, NULL);
    return ok;
}

/* Adds to *gone how many went. */
static bool delete_by(sqlite3 *db, const char *sql, int64_t bound, int *gone)
{
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(db, sql, -1, &s, NULL) == SQLITE_OK && sqlite3_bind_int64(s, 1, bound) == SQLITE_OK && sqlite3_step(s) == SQLITE_DONE;
    sqlite3_finalize(s);
    *gone += ok ? sqlite3_changes(db) : 0;
    return ok;
}

void store_evict_kept(struct lite *st, const struct store_keep *keep)
{
    static const char by_age[] = "DELETE FROM results WHERE rowid IN (SELECT rowid FROM results WHERE made < ?1 ORDER BY made LIMIT 1000)";
    static const char by_count[] = "DELETE FROM results WHERE rowid IN (SELECT rowid FROM results ORDER BY made DESC LIMIT 1000 OFFSET ?1)";
    int gone = 0;
    bool ok = (!keep->results_since || delete_by(st->cache, by_age, keep->results_since, &gone))
        && (!keep->results || delete_by(st->cache, by_count, keep->results, &gone));
    if (gone > 0)
        store_exec(st->cache, "DELETE FROM used WHERE id NOT IN (SELECT id FROM results)");
    if (gone > 0 || !ok)
        tell(st, ok, gone, sqlite3_errmsg(st->cache));
}
