/* Opening the files. user_version tells the schema; a newer one is refused, because an
 * older program could not keep what it does not know. An older queue is brought up to date
 * in one transaction; an older cache is dropped. */
#include "store_file.h"
#include "budget.h"
#include "digest.h"
#include "log.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SCHEMA_VERSION = 7, PATH_SIZE = 4096, LOCK_LOOK_US = 5000 };

/* Since version 4: bytes that only probe the disk. */
#define FROM_3 "CREATE TABLE filler(one INTEGER PRIMARY KEY, bytes BLOB NOT NULL);" FROM_4
/* Since version 5: who asked for a job, each with a place in his own list, and with the status of
 * the job beside it, so that a list costs what it shows; the seconds that a job may run. */
#define FROM_4 \
    "CREATE TABLE interests(seq INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL, owner TEXT NOT NULL," \
    " status INTEGER NOT NULL, UNIQUE(id, owner));" \
    "CREATE INDEX interests_of_owner ON interests(owner, seq);" \
    "CREATE INDEX interests_by_status ON interests(owner, status, seq);" \
    "CREATE TRIGGER job_made AFTER INSERT ON jobs BEGIN UPDATE interests SET status = new.status WHERE id = new.id; END;" \
    "CREATE TRIGGER job_moved AFTER UPDATE OF status ON jobs BEGIN UPDATE interests SET status = new.status WHERE id = new.id; END;" \
    "CREATE TRIGGER job_gone AFTER DELETE ON jobs BEGIN DELETE FROM interests WHERE id = old.id; END;" \
    "INSERT INTO interests(id, owner, status) SELECT id, owner, status FROM jobs ORDER BY seq;" \
    "ALTER TABLE jobs ADD COLUMN seconds INTEGER NOT NULL DEFAULT 0;" FROM_5
/* Since version 6: ended jobs by the time of their end, for those that are removed. */
#define FROM_5 "CREATE INDEX jobs_by_end ON jobs(finished) WHERE status >= 2;" FROM_6
/* Since version 7: the fences of runs, see store.h; leases end at a time in ms (0: never) and are
 * told how far a run is; which life of the store gives which epochs; who was served when. */
#define FROM_6 \
    "ALTER TABLE jobs ADD COLUMN epoch INTEGER NOT NULL DEFAULT 0;" \
    "ALTER TABLE jobs ADD COLUMN lease INTEGER NOT NULL DEFAULT 0;" \
    "ALTER TABLE jobs ADD COLUMN cancel INTEGER NOT NULL DEFAULT 0;" \
    "ALTER TABLE jobs ADD COLUMN stage TEXT;" \
    "ALTER TABLE jobs ADD COLUMN fraction REAL NOT NULL DEFAULT 0;" \
    "CREATE TABLE lives(one INTEGER PRIMARY KEY, number INTEGER NOT NULL);" \
    "CREATE TABLE turns(owner TEXT PRIMARY KEY, served INTEGER NOT NULL);"
#define CACHE_FROM_6 "ALTER TABLE results ADD COLUMN epoch INTEGER NOT NULL DEFAULT 0;"
#define FROM_2 "ALTER TABLE jobs ADD COLUMN owner TEXT NOT NULL DEFAULT '';UPDATE jobs SET sum=kept(id, request);" FROM_3

/* sum is the digest of the id and the request or result: SQLite does not notice a changed byte
 * inside a text. No row is without, as a changed byte can also make a column NULL. owner: the name of the token that submitted the job.
 * make[V] leads from version V (0: an empty file) to the present one; NULL: the file is dropped. */
static const struct { const char *name, *synchronous, *make[SCHEMA_VERSION]; } files[] = {
    [FILE_QUEUE] = { "queue.db", "PRAGMA synchronous=FULL", {
        "CREATE TABLE jobs("
        " seq INTEGER PRIMARY KEY AUTOINCREMENT,"
        " id TEXT NOT NULL UNIQUE,"
        " status INTEGER NOT NULL,"
        " attempts INTEGER NOT NULL,"
        " created INTEGER NOT NULL, started INTEGER NOT NULL, finished INTEGER NOT NULL,"
        " request BLOB NOT NULL,"
        " error TEXT,"
        " sum BLOB,"
        " owner TEXT NOT NULL DEFAULT '');"
        "CREATE INDEX jobs_by_status ON jobs(status, seq);" FROM_3,
        "ALTER TABLE jobs ADD COLUMN sum BLOB;" FROM_2,
        FROM_2,
        FROM_3,
        FROM_4,
        FROM_5,
        FROM_6 } },
    [FILE_CACHE] = { "cache.db", "PRAGMA synchronous=NORMAL", {
        "CREATE TABLE results(id TEXT PRIMARY KEY, made INTEGER NOT NULL, result BLOB NOT NULL, sum BLOB NOT NULL);" CACHE_FROM_6,
        [3] = CACHE_FROM_6, [4] = CACHE_FROM_6, [5] = CACHE_FROM_6, [6] = CACHE_FROM_6 } },
};

int store_file_lock(const char *folder, double wait, char *why, size_t size)
{
    char path[PATH_SIZE];
    if (mkdir(folder, 0700) != 0 && errno != EEXIST) {
        snprintf(why, size, "cannot make the state folder %s: %s", folder, strerror(errno));
        return -1;
    }
    snprintf(path, sizeof path, "%s/lock", folder);
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (fd < 0) {
        snprintf(why, size, "cannot open %s: %s", path, strerror(errno));
        return -1;
    }
    double until = sga_now() + wait;
    while (flock(fd, LOCK_EX | LOCK_NB) != 0) {
        if (sga_now() < until && (errno == EWOULDBLOCK || errno == EINTR)) {
            usleep(LOCK_LOOK_US);
            continue;
        }
        snprintf(why, size, "the state folder %s is in use by another sgad", folder);
        close(fd);
        return -1;
    }
    return fd;
}

static bool exec(sqlite3 *db, const char *sql)
{
    return sqlite3_exec(db, sql, NULL, NULL, NULL) == SQLITE_OK;
}

int store_file_version(sqlite3 *db)
{
    int version = -1;
    sqlite3_stmt *s;
    if (sqlite3_prepare_v2(db, "PRAGMA user_version", -1, &s, NULL) != SQLITE_OK)
        return -1;
    if (sqlite3_step(s) == SQLITE_ROW)
        version = sqlite3_column_int(s, 0);
    sqlite3_finalize(s);
    return version;
}

/* For SQL: kept(id, blob). */
static void kept(sqlite3_context *ctx, int count, sqlite3_value **value)
{
    unsigned char sum[DIGEST_BYTES];
    (void)count;
    const char *id = (const char *)sqlite3_value_text(value[0]);
    const void *blob = sqlite3_value_blob(value[1]);
    digest_kept(sum, id ? id : "", blob ? blob : "", (size_t)sqlite3_value_bytes(value[1]));
    sqlite3_result_blob(ctx, sum, sizeof sum, SQLITE_TRANSIENT);
}

static bool quick_check(sqlite3 *db)
{
    bool ok = false;
    sqlite3_stmt *s;
    if (sqlite3_prepare_v2(db, "PRAGMA quick_check(1)", -1, &s, NULL) != SQLITE_OK)
        return false;
    if (sqlite3_step(s) == SQLITE_ROW)
        ok = strcmp((const char *)sqlite3_column_text(s, 0), "ok") == 0;
    sqlite3_finalize(s);
    return ok;
}

/* Journal, schema and version of a read-write connection. */
static bool prepare_file(sqlite3 *db, enum store_file which, const char *path, bool *damaged, char *why, size_t size)
{
    int version = store_file_version(db);
    *damaged = false;
    if (version > SCHEMA_VERSION) {
        snprintf(why, size, "%s was written by a newer sgad (schema %d, this one knows %d)", path, version, SCHEMA_VERSION);
        return false;
    }
    if (version > 0 && version < SCHEMA_VERSION && !files[which].make[version]) {
        snprintf(why, size, "%s was written by an older sgad", path);
        *damaged = true;
        return false;
    }
    bool ok = version >= 0 && exec(db, "PRAGMA journal_mode=WAL") && exec(db, files[which].synchronous), sound = true;
    if (ok && version > 0 && which == FILE_QUEUE)
        ok = sound = quick_check(db);
    if (ok && version < SCHEMA_VERSION) {
        char sql[8192];
        snprintf(sql, sizeof sql, "BEGIN;%sPRAGMA user_version=%d;COMMIT", files[which].make[version], SCHEMA_VERSION);
        ok = sqlite3_create_function(db, "kept", 2, SQLITE_UTF8, NULL, kept, NULL, NULL) == SQLITE_OK && exec(db, sql);
    }
    int code = sqlite3_errcode(db);
    *damaged = !ok && (!sound || code == SQLITE_CORRUPT || code == SQLITE_NOTADB);
    if (!ok)
        snprintf(why, size, "%s cannot be used: %s%s", path, !sound ? "its content is damaged" : sqlite3_errmsg(db),
                 *damaged && which == FILE_QUEUE ? "; restore it from a backup, or move the whole folder away to start with an empty queue" : "");
    return ok;
}

/* *damaged tells a file that is no database, or a broken one, from other failures. */
static sqlite3 *open_once(const char *path, enum store_file which, bool write, bool *damaged, char *why, size_t size)
{
    sqlite3 *db = NULL;
    int flags = SQLITE_OPEN_NOMUTEX | (write ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READONLY);
    if (sqlite3_open_v2(path, &db, flags, NULL) != SQLITE_OK) {
        snprintf(why, size, "cannot open %s: %s", path, db ? sqlite3_errmsg(db) : "out of memory");
        sqlite3_close(db);
        return NULL;
    }
    sqlite3_busy_timeout(db, 5000);
    if (!write || prepare_file(db, which, path, damaged, why, size))
        return db;
    sqlite3_close(db);
    return NULL;
}

static void drop(const char *path)
{
    static const char *const tails[] = { "", "-wal", "-shm" };
    char name[PATH_SIZE + 8];
    for (int i = 0; i < 3; i++) {
        snprintf(name, sizeof name, "%s%s", path, tails[i]);
        unlink(name);
    }
}

bool store_file_fill(sqlite3 *db, size_t bytes)
{
    char sql[80] = "DELETE FROM filler";
    if (bytes)
        snprintf(sql, sizeof sql, "INSERT OR REPLACE INTO filler VALUES(1, zeroblob(%zu))", bytes);
    return exec(db, sql);
}

bool store_file_broken(int code)
{
    return (code & 0xff) == SQLITE_CORRUPT || (code & 0xff) == SQLITE_NOTADB;
}

sqlite3 *store_file_fresh(const char *folder, enum store_file which, char *why, size_t size)
{
    char path[PATH_SIZE];
    bool damaged = false;
    snprintf(path, sizeof path, "%s/%s", folder, files[which].name);
    drop(path);
    return open_once(path, which, true, &damaged, why, size);
}

sqlite3 *store_file_open(const char *folder, enum store_file which, bool write, char *why, size_t size)
{
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s", folder, files[which].name);
    bool damaged = false;
    sqlite3 *db = open_once(path, which, write, &damaged, why, size);
    if (db || !write || which != FILE_CACHE || !damaged)
        return db;
    /* Results can be computed again: a cache that cannot be read is started afresh. */
    log_event(LOG_L_WARN, "cache_dropped", "reason", why, NULL);
    return store_file_fresh(folder, which, why, size);
}

sqlite3_stmt *store_file_prepare(sqlite3 *db, const char *sql, char *why, size_t size)
{
    sqlite3_stmt *s = NULL;
    if (sqlite3_prepare_v3(db, sql, -1, SQLITE_PREPARE_PERSISTENT, &s, NULL) != SQLITE_OK)
        snprintf(why, size, "the store's schema does not fit: %s", sqlite3_errmsg(db));
    return s;
}
