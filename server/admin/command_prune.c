/* sgad prune: removes ended jobs and results while no daemon runs, and gives their space back. A running
 * daemon does it by itself (keep-days, cache-days, ...): only it writes to its files. */
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

/* What may be said, and how. */
enum { OLDER, KEEP, BYTES, RESULTS_OLDER, RESULTS_KEEP, BOUNDS };
static const struct { const char *name, *tail; } bounds[BOUNDS] = {
    [OLDER] = { "older", "d" }, [KEEP] = { "keep", "" }, [BYTES] = { "bytes", "" }, [RESULTS_OLDER] = { "results-older", "d" }, [RESULTS_KEEP] = { "results-keep", "" },
};

struct wish {
    long bound[BOUNDS];              /* -1: not said */
    const char *state, *config;
};

static const char usage[] = "usage: sgad prune --state DIR | --config FILE [--older DAYSd] [--keep JOBS] [--bytes BYTES]\n"
                            "                  [--results-older DAYSd] [--results-keep RESULTS]\n";

/* A whole number from 0, with this tail; -1: it is none. */
static long number(const char *text, const char *tail)
{
    char *end;
    errno = 0;
    long n = strtol(text, &end, 10);
    return errno || end == text || strcmp(end, tail) != 0 || n < 0 || n > 1000000000000 ? -1 : n;
}

/* False: it is no option of this command, or not such a number. */
static bool read_option(int argc, char **argv, int *i, struct wish *w)
{
    const char *value;
    if ((value = command_option(argc, argv, i, "state")))
        w->state = value;
    else if ((value = command_option(argc, argv, i, "config")))
        w->config = value;
    for (int k = 0; !value && k < BOUNDS; k++)
        if ((value = command_option(argc, argv, i, bounds[k].name)) && (w->bound[k] = number(value, bounds[k].tail)) < 0)
            return false;
    return value;
}

static bool read_wish(int argc, char **argv, struct wish *w)
{
    bool any = false;
    *w = (struct wish){ .state = NULL };
    for (int k = 0; k < BOUNDS; k++)
        w->bound[k] = -1;
    for (int i = 2; i < argc; i++)
        if (!read_option(argc, argv, &i, w))
            return false;
    for (int k = 0; k < BOUNDS; k++)
        any |= w->bound[k] >= 0;
    return any;
}

/* Adds to *removed how many rows went, unless NULL. */
static bool run(sqlite3 *db, const char *sql, int64_t bound, int *removed)
{
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(db, sql, -1, &s, NULL) == SQLITE_OK;
    if (ok && bound >= 0)
        sqlite3_bind_int64(s, 1, bound);
    ok = ok && sqlite3_step(s) == SQLITE_DONE;
    sqlite3_finalize(s);
    if (ok && removed)
        *removed += sqlite3_changes(db);
    return ok;
}

/* Milliseconds since 1970, so many days ago; -1: not said. */
static int64_t since(long days)
{
    return days < 0 ? -1 : clock_ms() - days * (int64_t)86400000;
}

static const char jobs_by_age[] = "DELETE FROM jobs WHERE status >= 2 AND finished < ?1";
static const char jobs_by_number[] = "DELETE FROM jobs WHERE seq IN (SELECT seq FROM jobs WHERE status >= 2 ORDER BY finished DESC LIMIT -1 OFFSET ?1)";
static const char jobs_by_bytes[] = "DELETE FROM jobs WHERE seq IN (SELECT seq FROM (SELECT seq, sum(n) OVER (ORDER BY finished DESC, seq DESC) AS upto FROM"
                                    " (SELECT seq, finished, length(request) AS n FROM jobs WHERE status >= 2)) WHERE upto > ?1)";
static const char results_by_age[] = "DELETE FROM results WHERE made < ?1";
static const char results_by_number[] = "DELETE FROM results WHERE rowid IN (SELECT rowid FROM results ORDER BY made DESC LIMIT -1 OFFSET ?1)";

struct rule { const char *sql; int64_t bound; };

static bool prune(sqlite3 *db, const struct rule *rule, int count, const char *what)
{
    int removed = 0;
    bool ok = true;
    for (int i = 0; ok && i < count; i++)
        ok = rule[i].bound < 0 || run(db, rule[i].sql, rule[i].bound, &removed);
    if (ok && run(db, "VACUUM", -1, NULL)) {
        printf("%d %s removed\n", removed, what);
        return true;
    }
    fprintf(stderr, "sgad: %s\n", sqlite3_errmsg(db));
    return false;
}

/* Under the folder's lock. */
static bool prune_file(const char *state, enum store_file which, const struct rule *rule, int count, const char *what)
{
    char why[512];
    bool asked = false;
    for (int i = 0; i < count; i++)
        asked |= rule[i].bound >= 0;
    if (!asked)
        return true;
    sqlite3 *db = store_file_open(state, which, true, why, sizeof why);
    if (!db)
        fprintf(stderr, "sgad: %s\n", why);
    bool ok = db && prune(db, rule, count, what);
    sqlite3_close(db);
    return ok;
}

static bool prune_state(const char *state, const struct wish *w)
{
    const struct rule jobs[] = { { jobs_by_age, since(w->bound[OLDER]) }, { jobs_by_number, w->bound[KEEP] }, { jobs_by_bytes, w->bound[BYTES] } };
    const struct rule results[] = { { results_by_age, since(w->bound[RESULTS_OLDER]) }, { results_by_number, w->bound[RESULTS_KEEP] } };
    char why[512], path[STATE_PATH + 32];
    struct stat st;
    snprintf(path, sizeof path, "%s/queue.db", state);
    if (stat(path, &st) != 0) {
        fprintf(stderr, "sgad: there is no state in %s\n", state);
        return false;
    }
    int lock = store_file_lock(state, 0, why, sizeof why);
    if (lock < 0) {
        fprintf(stderr, "sgad: %s\n", why);
        return false;
    }
    bool ok = prune_file(state, FILE_QUEUE, jobs, 3, "rows") && prune_file(state, FILE_CACHE, results, 2, "results");
    close(lock);
    return ok;
}

int command_prune(int argc, char **argv)
{
    struct wish w;
    if (!read_wish(argc, argv, &w)) {
        fputs(usage, stderr);
        return COMMAND_USAGE;
    }
    char *state = command_state(w.state, w.config);
    int status = !state ? COMMAND_USAGE : prune_state(state, &w) ? COMMAND_DONE : COMMAND_FAILED;
    free(state);
    return status;
}
