/* sgad prune: removes ended jobs while no daemon runs, and gives their space back. A running
 * daemon does it by itself (keep-days, keep-jobs): only it writes to its files. */
#include "command.h"
#include "clock.h"
#include "state_files.h"
#include "store_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct wish { const char *older, *keep, *state, *config; };

static const char usage[] = "usage: sgad prune --state DIR | --config FILE [--older DAYSd] [--keep JOBS]\n";

static bool read_wish(int argc, char **argv, struct wish *w)
{
    const struct { const char *name; const char **at; } options[] = {
        { "older", &w->older }, { "keep", &w->keep }, { "state", &w->state }, { "config", &w->config },
    };
    for (int i = 2; i < argc; i++) {
        const char *value = NULL;
        for (size_t k = 0; !value && k < sizeof options / sizeof *options; k++)
            if ((value = command_option(argc, argv, &i, options[k].name)))
                *options[k].at = value;
        if (!value)
            return false;
    }
    return w->older || w->keep;
}

/* A whole number from 0, with this tail; -1: it is none. */
static long number(const char *text, const char *tail)
{
    char *end;
    errno = 0;
    long n = strtol(text, &end, 10);
    return errno || end == text || strcmp(end, tail) != 0 || n < 0 || n > 1000000000 ? -1 : n;
}

static bool run(sqlite3 *db, const char *sql, int64_t bound)
{
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(db, sql, -1, &s, NULL) == SQLITE_OK;
    if (ok && bound >= 0)
        sqlite3_bind_int64(s, 1, bound);
    ok = ok && sqlite3_step(s) == SQLITE_DONE;
    sqlite3_finalize(s);
    return ok;
}

static bool prune(sqlite3 *db, long days, long keep)
{
    int before = sqlite3_total_changes(db);
    bool ok = (days < 0 || run(db, "DELETE FROM jobs WHERE status >= 2 AND finished < ?1", clock_ms() - days * (int64_t)86400000))
        && (keep < 0 || run(db, "DELETE FROM jobs WHERE seq IN (SELECT seq FROM jobs WHERE status >= 2 ORDER BY finished DESC LIMIT -1 OFFSET ?1)", keep));
    int removed = sqlite3_total_changes(db) - before;
    if (ok && run(db, "VACUUM", -1)) {
        printf("%d rows removed\n", removed);
        return true;
    }
    fprintf(stderr, "sgad: %s\n", sqlite3_errmsg(db));
    return false;
}

/* Under the folder's lock, which is given back. */
static bool prune_state(const char *state, long days, long keep)
{
    char why[512], path[STATE_PATH + 32];
    struct stat st;
    snprintf(path, sizeof path, "%s/queue.db", state);
    if (stat(path, &st) != 0) {
        fprintf(stderr, "sgad: there is no state in %s\n", state);
        return false;
    }
    int lock = store_file_lock(state, 0, why, sizeof why);
    sqlite3 *db = lock >= 0 ? store_file_open(state, FILE_QUEUE, true, why, sizeof why) : NULL;
    if (!db)
        fprintf(stderr, "sgad: %s\n", why);
    bool ok = db && prune(db, days, keep);
    sqlite3_close(db);
    if (lock >= 0)
        close(lock);
    return ok;
}

int command_prune(int argc, char **argv)
{
    struct wish w = { NULL };
    bool good = read_wish(argc, argv, &w);
    long days = w.older ? number(w.older, "d") : -1, keep = w.keep ? number(w.keep, "") : -1;
    if (!good || (w.older && days < 0) || (w.keep && keep < 0)) {
        fputs(usage, stderr);
        return COMMAND_USAGE;
    }
    char *state = command_state(w.state, w.config);
    int status = !state ? COMMAND_USAGE : prune_state(state, days, keep) ? COMMAND_DONE : COMMAND_FAILED;
    free(state);
    return status;
}
