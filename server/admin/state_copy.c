/* Copying a state: into TO.partial, checked there, made durable, and then given its name. */
#include "state_files.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool failed(const char *what, const char *path)
{
    fprintf(stderr, "sgad: cannot %s %s: %s\n", what, path, strerror(errno));
    return false;
}

static bool copy_file(sqlite3 *from, const char *folder, const char *name)
{
    char path[STATE_PATH + 32];
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

static bool sync_path(const char *path)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    bool ok = fd >= 0 && fsync(fd) == 0;
    if (fd >= 0)
        close(fd);
    return ok || failed("write", path);
}

/* The name of the state, where it has one. */
static bool copy_instance(const char *from, const char *to)
{
    char path[STATE_PATH + 32], text[64];
    snprintf(path, sizeof path, "%s/instance", from);
    FILE *f = fopen(path, "re");
    if (!f)
        return errno == ENOENT || failed("read", path);
    size_t n = fread(text, 1, sizeof text, f);
    fclose(f);
    snprintf(path, sizeof path, "%s/instance", to);
    f = fopen(path, "we");
    bool ok = f && fwrite(text, 1, n, f) == n;
    if (f && fclose(f) != 0)
        ok = false;
    return ok ? sync_path(path) : failed("write", path);
}

static bool copy_files(const char *from, const char *to)
{
    int found = 0;
    for (int i = 0; i < STATE_FILES; i++) {
        char path[STATE_PATH + 32];
        sqlite3 *db;
        if (!state_open(from, state_files[i], &db))
            return false;
        if (!db)
            continue;
        bool ok = copy_file(db, to, state_files[i]);
        sqlite3_close(db);
        snprintf(path, sizeof path, "%s/%s", to, state_files[i]);
        if (!ok || !sync_path(path))
            return false;
        found++;
    }
    if (!found)
        fprintf(stderr, "sgad: there is no state in %s\n", from);
    return found && copy_instance(from, to);
}

/* What is left of an attempt: its files are known by name. */
static void discard(const char *folder)
{
    static const char *const tails[] = { "", "-wal", "-shm", "-journal" };
    char path[STATE_PATH + 32];
    for (int i = 0; i < STATE_FILES; i++)
        for (int k = 0; k < 4; k++) {
            snprintf(path, sizeof path, "%s/%s%s", folder, state_files[i], tails[k]);
            unlink(path);
        }
    snprintf(path, sizeof path, "%s/instance", folder);
    unlink(path);
    rmdir(folder);
}

static bool parent_synced(const char *path)
{
    char parent[STATE_PATH];
    snprintf(parent, sizeof parent, "%s", path);
    char *slash = strrchr(parent, '/');
    if (slash)
        slash[slash == parent] = 0;
    return sync_path(slash ? parent : ".");
}

static bool copy_whole(const char *from, const char *partial, const char *to)
{
    if (!copy_files(from, partial))
        return false;
    if (!state_sound(partial, true)) {
        fprintf(stderr, "sgad: the copy of %s is damaged, as sgad check --state %s tells where that is\n", from, from);
        return false;
    }
    return sync_path(partial) && (rename(partial, to) == 0 || failed("make", to)) && parent_synced(to);
}

bool state_copy(const char *from, const char *to)
{
    char partial[STATE_PATH];
    struct stat st;
    size_t n = strlen(to);
    while (n > 1 && to[n - 1] == '/')
        n--;
    snprintf(partial, sizeof partial, "%.*s.partial", (int)n, to);
    umask(077);
    if (stat(to, &st) == 0) {
        fprintf(stderr, "sgad: %s is there already; nothing is overwritten\n", to);
        return false;
    }
    discard(partial);          /* of an attempt that was cut short */
    if (mkdir(partial, 0700) != 0)
        return failed("make", partial);
    bool ok = copy_whole(from, partial, to);
    if (!ok)
        discard(partial);
    return ok;
}
