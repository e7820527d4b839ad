/* Looking for damage. */
#include "state_files.h"
#include "store_pieces.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum { BUSY_MS = 10000, FAULTS = 10 };

const char *const state_files[STATE_FILES] = { "queue.db", "cache.db", "tokens.db" };

bool state_open(const char *state, const char *name, sqlite3 **db)
{
    char path[STATE_PATH];
    struct stat st;
    *db = NULL;
    snprintf(path, sizeof path, "%s/%s", state, name);
    if (stat(path, &st) != 0 && errno == ENOENT)
        return true;
    /* What a command that was cut short left in a journal is rolled back; otherwise nothing here writes. */
    char journal[STATE_PATH + 16];
    snprintf(journal, sizeof journal, "%s-journal", path);
    int flags = stat(journal, &st) == 0 ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY;
    if (sqlite3_open_v2(path, db, flags | SQLITE_OPEN_NOMUTEX, NULL) == SQLITE_OK) {
        sqlite3_busy_timeout(*db, BUSY_MS);
        return true;
    }
    fprintf(stderr, "sgad: cannot open %s: %s\n", path, *db ? sqlite3_errmsg(*db) : "out of memory");
    sqlite3_close(*db);
    *db = NULL;
    return false;
}

/* Prints what SQLite finds, at most ten faults of each file. */
static bool pages_sound(sqlite3 *db, const char *name, bool quiet)
{
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(db, "PRAGMA integrity_check(10)", -1, &s, NULL) == SQLITE_OK;
    int rc = SQLITE_DONE, rows = 0;
    while (ok && (rc = sqlite3_step(s)) == SQLITE_ROW) {
        const char *text = (const char *)sqlite3_column_text(s, 0);
        rows++;
        if (!text || strcmp(text, "ok") != 0) {
            ok = false;
            if (!quiet)
                printf("%s: %s\n", name, text ? text : "damaged");
        }
    }
    if (ok && (rc != SQLITE_DONE || rows == 0))
        ok = false;
    if (!ok && rows == 0 && !quiet)
        printf("%s: %s\n", name, sqlite3_errmsg(db));
    sqlite3_finalize(s);
    return ok;
}

static bool texts_sound(sqlite3 *db, const char *name, const char *sql, bool quiet)
{
    sqlite3_stmt *s = NULL, *pieces = NULL;
    int faults = 0, rc = sqlite3_prepare_v2(db, sql, -1, &s, NULL);
    sqlite3_prepare_v2(db, STORE_PIECES, -1, &pieces, NULL);       /* a file of requests has none, nor has an older one of results */
    while (rc == SQLITE_OK && faults < FAULTS && sqlite3_step(s) == SQLITE_ROW)
        if (!store_pieces_genuine(s, pieces) && ++faults && !quiet)
            printf("%s: the text of job %.40s is not what was written\n", name, sqlite3_column_text(s, 0));
    if (rc != SQLITE_OK && !quiet)
        printf("%s: %s\n", name, sqlite3_errmsg(db));
    sqlite3_finalize(s);
    sqlite3_finalize(pieces);
    return rc == SQLITE_OK && faults == 0;
}

static bool file_sound(sqlite3 *db, const char *name, bool quiet)
{
    static const char *const texts[STATE_FILES] = { "SELECT id, request, sum FROM jobs", "SELECT id, result, sum FROM results", NULL };
    bool ok = pages_sound(db, name, quiet);
    for (int i = 0; ok && i < STATE_FILES; i++)
        if (strcmp(name, state_files[i]) == 0 && texts[i])
            ok = texts_sound(db, name, texts[i], quiet);
    if (ok && !quiet)
        printf("%s: ok\n", name);
    return ok;
}

bool state_sound(const char *state, bool quiet)
{
    bool ok = true;
    int found = 0;
    for (int i = 0; i < STATE_FILES; i++) {
        sqlite3 *db;
        if (!state_open(state, state_files[i], &db)) {
            ok = false;
        } else if (db) {
            found++;
            ok &= file_sound(db, state_files[i], quiet);
            sqlite3_close(db);
        }
    }
    if (!found && ok)
        fprintf(stderr, "sgad: there is no state in %s\n", state);
    return found && ok;
}
