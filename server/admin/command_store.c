/* sgad backup and sgad check: the state folder, while a daemon may be using it. Both only
 * read; SQLite's snapshots keep them apart from the daemon's writer. */
#include "command.h"

#include <errno.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { PATH_SIZE = 4096, BUSY_MS = 10000 };

/* In the order of copying: a job that the copied queue calls done has its result in the
 * cache, which is copied after it. */
static const char *const files[] = { "queue.db", "cache.db", "tokens.db" };
enum { FILES = sizeof files / sizeof *files };

struct wish { const char *folder, *state, *config; };

static int bad(const char *usage, const char *arg)
{
    fprintf(stderr, "sgad: unexpected or incomplete: '%s'\nusage: sgad %s\n", arg, usage);
    return COMMAND_USAGE;
}

static int read_wish(int argc, char **argv, bool folder, const char *usage, struct wish *w)
{
    for (int i = 2; i < argc; i++) {
        const char *value, *arg = argv[i];
        if ((value = command_option(argc, argv, &i, "state")))
            w->state = value;
        else if ((value = command_option(argc, argv, &i, "config")))
            w->config = value;
        else if (folder && !w->folder && *arg != '-')
            w->folder = arg;
        else
            return bad(usage, arg);
    }
    return folder && !w->folder ? bad(usage, "no folder") : COMMAND_DONE;
}

/* Opens a file of the state for reading. True with *db NULL: there is none. */
static bool open_source(const char *state, const char *name, sqlite3 **db)
{
    char path[PATH_SIZE];
    struct stat st;
    *db = NULL;
    snprintf(path, sizeof path, "%s/%s", state, name);
    if (stat(path, &st) != 0 && errno == ENOENT)
        return true;
    if (sqlite3_open_v2(path, db, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, NULL) == SQLITE_OK) {
        sqlite3_busy_timeout(*db, BUSY_MS);
        return true;
    }
    fprintf(stderr, "sgad: cannot open %s: %s\n", path, *db ? sqlite3_errmsg(*db) : "out of memory");
    sqlite3_close(*db);
    *db = NULL;
    return false;
}

static bool copy(sqlite3 *from, const char *folder, const char *name)
{
    char path[PATH_SIZE];
    sqlite3 *to = NULL;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    bool ok = sqlite3_open_v2(path, &to, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, NULL) == SQLITE_OK;
    sqlite3_backup *b = ok ? sqlite3_backup_init(to, "main", from, "main") : NULL;
    if (b) {
        /* All pages in one step: one snapshot, however much the daemon writes meanwhile. */
        int rc = sqlite3_backup_step(b, -1);
        ok = sqlite3_backup_finish(b) == SQLITE_OK && rc == SQLITE_DONE;
    } else {
        ok = false;
    }
    if (!ok)
        fprintf(stderr, "sgad: cannot write %s: %s\n", path, to ? sqlite3_errmsg(to) : "out of memory");
    sqlite3_close(to);
    return ok;
}

static int backup(const char *state, const char *folder)
{
    int found = 0;
    umask(077);
    if (mkdir(folder, 0700) != 0) {
        fprintf(stderr, "sgad: cannot make %s: %s\n", folder, strerror(errno));
        return COMMAND_FAILED;
    }
    for (int i = 0; i < FILES; i++) {
        sqlite3 *db;
        if (!open_source(state, files[i], &db))
            return COMMAND_FAILED;
        if (!db)
            continue;
        bool ok = copy(db, folder, files[i]);
        sqlite3_close(db);
        if (!ok)
            return COMMAND_FAILED;
        found++;
    }
    if (found)
        return COMMAND_DONE;
    fprintf(stderr, "sgad: there is no state in %s\n", state);
    rmdir(folder);
    return COMMAND_FAILED;
}

int command_backup(int argc, char **argv)
{
    struct wish w = { NULL };
    int status = read_wish(argc, argv, true, "backup FOLDER --state DIR | --config FILE", &w);
    if (status != COMMAND_DONE)
        return status;
    char *state = command_state(w.state, w.config);
    status = state ? backup(state, w.folder) : COMMAND_USAGE;
    free(state);
    return status;
}

/* Prints what SQLite finds, at most ten faults of each file. */
static bool sound(sqlite3 *db, const char *name)
{
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(db, "PRAGMA integrity_check(10)", -1, &s, NULL) == SQLITE_OK;
    int rc = SQLITE_DONE, rows = 0;
    while (ok && (rc = sqlite3_step(s)) == SQLITE_ROW) {
        const char *text = (const char *)sqlite3_column_text(s, 0);
        rows++;
        if (!text || strcmp(text, "ok") != 0) {
            ok = false;
            printf("%s: %s\n", name, text ? text : "damaged");
        }
    }
    if (ok && (rc != SQLITE_DONE || rows == 0))
        ok = false;
    if (!ok && rows == 0)
        printf("%s: %s\n", name, sqlite3_errmsg(db));
    sqlite3_finalize(s);
    if (ok)
        printf("%s: ok\n", name);
    return ok;
}

static int check(const char *state)
{
    bool ok = true;
    int found = 0;
    for (int i = 0; i < FILES; i++) {
        sqlite3 *db;
        if (!open_source(state, files[i], &db)) {
            ok = false;
        } else if (db) {
            found++;
            ok &= sound(db, files[i]);
            sqlite3_close(db);
        }
    }
    if (!found && ok)
        fprintf(stderr, "sgad: there is no state in %s\n", state);
    return found && ok ? COMMAND_DONE : COMMAND_FAILED;
}

int command_check(int argc, char **argv)
{
    struct wish w = { NULL };
    int status = read_wish(argc, argv, false, "check --state DIR | --config FILE", &w);
    if (status != COMMAND_DONE)
        return status;
    char *state = command_state(w.state, w.config);
    status = state ? check(state) : COMMAND_USAGE;
    free(state);
    return status;
}
