/* tokens.db. With a rollback journal: each write changes the file itself, which is how a
 * running daemon notices, and commands and daemon may use it at the same time. */
#include "tokens_place.h"
#include "postgres.h"

#include <errno.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "store_file.h"

enum { VERSION = 1, PATH_SIZE = 4096, BUSY_MS = 5000 };

static const char schema[] =
    "BEGIN IMMEDIATE;"
    "CREATE TABLE IF NOT EXISTS tokens("
    " name TEXT PRIMARY KEY, sum BLOB NOT NULL UNIQUE, scopes INTEGER NOT NULL,"
    " created INTEGER NOT NULL, expires INTEGER NOT NULL, revoked INTEGER NOT NULL,"
    " jobs INTEGER NOT NULL, bytes INTEGER NOT NULL, waiters INTEGER NOT NULL, seconds INTEGER NOT NULL);"
    "PRAGMA user_version=1;"
    "COMMIT";

static bool fail(sqlite3 *db, const char *path, char *why, size_t size)
{
    snprintf(why, size, "%s cannot be used: %s", path, db ? sqlite3_errmsg(db) : "out of memory");
    sqlite3_close(db);
    return false;
}

static bool open_file(const char *path, bool write, sqlite3 **out, char *why, size_t size)
{
    sqlite3 *db = NULL;
    /* Readers too: the journal of a command that was cut short is rolled back by who comes next. */
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | (write ? SQLITE_OPEN_CREATE : 0);
    if (sqlite3_open_v2(path, &db, flags, NULL) != SQLITE_OK)
        return fail(db, path, why, size);
    sqlite3_busy_timeout(db, BUSY_MS);
    int version = store_file_version(db);
    if (version > VERSION) {
        snprintf(why, size, "%s was written by a newer sgad", path);
        sqlite3_close(db);
        return false;
    }
    if (version < 0 || (write && version == 0 && sqlite3_exec(db, schema, NULL, NULL, NULL) != SQLITE_OK))
        return fail(db, path, why, size);
    *out = db;
    return true;
}

static void read_row(sqlite3_stmt *s, struct token *t)
{
    *t = (struct token){ .scopes = (unsigned)sqlite3_column_int(s, 2), .created = sqlite3_column_int64(s, 3),
                         .expires = sqlite3_column_int64(s, 4), .revoked = sqlite3_column_int64(s, 5) };
    t->quota = (struct quota){ sqlite3_column_int64(s, 6), sqlite3_column_int64(s, 7),
                               sqlite3_column_int64(s, 8), sqlite3_column_int64(s, 9) };
    const char *name = (const char *)sqlite3_column_text(s, 0);
    snprintf(t->name, sizeof t->name, "%s", name ? name : "");
    if (sqlite3_column_bytes(s, 1) == DIGEST_BYTES)
        memcpy(t->sum, sqlite3_column_blob(s, 1), DIGEST_BYTES);
    else
        t->revoked = 1;       /* no digest: it fits nobody */
}

static bool read_rows(sqlite3_stmt *s, struct token_list *out)
{
    int rc;
    size_t room = 0;
    while ((rc = sqlite3_step(s)) == SQLITE_ROW) {
        if (out->count == room) {
            room = room ? 2 * room : 16;
            struct token *more = realloc(out->token, room * sizeof *more);
            if (!more)
                return false;
            out->token = more;
        }
        read_row(s, &out->token[out->count++]);
    }
    return rc == SQLITE_DONE;
}

bool tokens_read(const char *folder, struct token_list *out, char *why, size_t size)
{
    char path[PATH_SIZE];
    sqlite3 *db;
    sqlite3_stmt *s = NULL;
    if (postgres_address(folder))
        return tokens_shared_read(folder, out, why, size);
    *out = (struct token_list){ NULL, 0 };
    snprintf(path, sizeof path, "%s/tokens.db", folder);
    if (access(path, F_OK) != 0 && errno == ENOENT)
        return true;
    if (!open_file(path, false, &db, why, size))
        return false;
    bool ok = sqlite3_prepare_v2(db, "SELECT name, sum, scopes, created, expires, revoked, jobs, bytes, waiters, seconds"
                                     " FROM tokens ORDER BY created, name", -1, &s, NULL) == SQLITE_OK && read_rows(s, out);
    sqlite3_finalize(s);
    if (!ok) {
        free(out->token);
        *out = (struct token_list){ NULL, 0 };
        return fail(db, path, why, size);
    }
    sqlite3_close(db);
    return true;
}

/* Made by root for a daemon that runs as somebody else: the file is that one's. */
static void give_away(const char *folder, const char *path)
{
    struct stat st;
    if (geteuid() == 0 && stat(folder, &st) == 0 && st.st_uid != 0 && chown(path, st.st_uid, st.st_gid) != 0)
        fprintf(stderr, "sgad: cannot give %s to the owner of its folder: %s\n", path, strerror(errno));
}

static bool open_to_write(const char *folder, char path[PATH_SIZE], sqlite3 **db, char *why, size_t size)
{
    if (mkdir(folder, 0700) != 0 && errno != EEXIST) {
        snprintf(why, size, "cannot make the state folder %s: %s", folder, strerror(errno));
        return false;
    }
    snprintf(path, PATH_SIZE, "%s/tokens.db", folder);
    mode_t before = umask(077);
    bool ok = open_file(path, true, db, why, size);
    umask(before);
    if (ok)
        give_away(folder, path);
    return ok;
}

bool tokens_add(const char *folder, const struct token *t, char *why, size_t size)
{
    char path[PATH_SIZE];
    sqlite3 *db;
    sqlite3_stmt *s = NULL;
    if (postgres_address(folder))
        return tokens_shared_add(folder, t, why, size);
    if (!open_to_write(folder, path, &db, why, size))
        return false;
    if (sqlite3_prepare_v2(db, "INSERT INTO tokens VALUES(?1, ?2, ?3, ?4, ?5, 0, ?6, ?7, ?8, ?9)", -1, &s, NULL) != SQLITE_OK)
        return fail(db, path, why, size);
    sqlite3_bind_text(s, 1, t->name, -1, SQLITE_STATIC);
    sqlite3_bind_blob(s, 2, t->sum, DIGEST_BYTES, SQLITE_STATIC);
    sqlite3_bind_int(s, 3, (int)t->scopes);
    sqlite3_bind_int64(s, 4, t->created);
    sqlite3_bind_int64(s, 5, t->expires);
    sqlite3_bind_int64(s, 6, t->quota.jobs);
    sqlite3_bind_int64(s, 7, t->quota.bytes);
    sqlite3_bind_int64(s, 8, t->quota.waiters);
    sqlite3_bind_int64(s, 9, t->quota.seconds);
    int rc = sqlite3_step(s);
    sqlite3_finalize(s);
    if (rc == SQLITE_CONSTRAINT) {
        snprintf(why, size, "there is a token called '%s' already; a name is used once, also after its token was revoked", t->name);
        sqlite3_close(db);
        return false;
    }
    if (rc != SQLITE_DONE)
        return fail(db, path, why, size);
    sqlite3_close(db);
    return true;
}

bool tokens_revoke(const char *folder, const char *name, int64_t now, char *why, size_t size)
{
    char path[PATH_SIZE];
    sqlite3 *db;
    sqlite3_stmt *s = NULL;
    if (postgres_address(folder))
        return tokens_shared_revoke(folder, name, now, why, size);
    if (!open_to_write(folder, path, &db, why, size))
        return false;
    if (sqlite3_prepare_v2(db, "UPDATE tokens SET revoked = ?2 WHERE name = ?1 AND revoked = 0", -1, &s, NULL) != SQLITE_OK)
        return fail(db, path, why, size);
    sqlite3_bind_text(s, 1, name, -1, SQLITE_STATIC);
    sqlite3_bind_int64(s, 2, now);
    int rc = sqlite3_step(s);
    sqlite3_finalize(s);
    if (rc != SQLITE_DONE)
        return fail(db, path, why, size);
    bool changed = sqlite3_changes(db) > 0;
    sqlite3_close(db);
    if (!changed)
        snprintf(why, size, "there is no token called '%s' that is in force", name);
    return changed;
}
