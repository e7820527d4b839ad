/* The folder of the state, by its files' names and inodes. */
#include "store_place.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

enum { PATH_SIZE = 4096, NAME_BYTES = 16, SPARE_PART = 8, SPARE_MOST = 64 << 20 };

static bool look(const char *folder, const char *name, struct stat *st)
{
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return stat(path, st) == 0;
}

bool store_place_of(const char *folder, struct store_place *place)
{
    struct stat st;
    if (!look(folder, "queue.db", &st))
        return false;
    *place = (struct store_place){ st.st_dev, st.st_ino };
    return true;
}

unsigned long long store_place_free(const char *folder)
{
    struct statvfs v;
    return statvfs(folder, &v) == 0 ? (unsigned long long)v.f_bavail * v.f_frsize : 0;
}

unsigned long long store_place_spare(const char *folder)
{
    struct statvfs v;
    unsigned long long part = statvfs(folder, &v) == 0 ? (unsigned long long)v.f_blocks * v.f_frsize / SPARE_PART : 0;
    return part < SPARE_MOST ? part : SPARE_MOST;
}

unsigned long long store_place_size(const char *folder, const char *name)
{
    struct stat file;
    return look(folder, name, &file) ? (unsigned long long)file.st_size : 0;
}

unsigned long long store_place_bytes(const char *folder, const char *name)
{
    char wal[64];
    snprintf(wal, sizeof wal, "%s-wal", name);
    return store_place_size(folder, name) + store_place_size(folder, wal);
}

bool store_place_same(const struct store_place *a, const struct store_place *b)
{
    return a->device == b->device && a->inode == b->inode;
}

bool store_place_sound(const char *folder, char *why, size_t size)
{
    struct stat queue, other;
    bool there = look(folder, "queue.db", &queue);
    if ((there && queue.st_size > 0) || (!look(folder, "instance", &other) && !look(folder, "cache.db", &other)))
        return true;
    snprintf(why, size, "%s/queue.db is %s, though this folder was in use: the accepted jobs are in it. Is everything mounted? "
             "Restore it from a backup, or move the whole folder away to start with an empty queue", folder, there ? "empty" : "missing");
    return false;
}

/* A new file with its name's text, on disk. */
static bool write_name(const char *path)
{
    unsigned char bits[NAME_BYTES];
    char text[2 * NAME_BYTES + 2];
    if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits)
        return false;
    for (int i = 0; i < NAME_BYTES; i++)
        snprintf(text + 2 * i, 3, "%02x", bits[i]);
    text[2 * NAME_BYTES] = '\n';
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0)
        return false;
    bool ok = write(fd, text, sizeof text - 1) == (ssize_t)sizeof text - 1 && fsync(fd) == 0;
    return close(fd) == 0 && ok;
}

static bool sync_folder(const char *folder)
{
    int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    bool ok = fd >= 0 && fsync(fd) == 0;
    if (fd >= 0)
        close(fd);
    return ok;
}

bool store_place_mark(const char *folder, char *why, size_t size)
{
    char path[PATH_SIZE], fresh[PATH_SIZE + 8];
    struct stat st;
    if (look(folder, "instance", &st))
        return true;
    snprintf(path, sizeof path, "%s/instance", folder);
    snprintf(fresh, sizeof fresh, "%s.new", path);
    if (write_name(fresh) && rename(fresh, path) == 0 && sync_folder(folder))
        return true;
    snprintf(why, size, "cannot write %s: %s", path, strerror(errno));
    return false;
}
