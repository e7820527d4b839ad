/* Before each text stand SPOOL_HEAD bytes, and before them what it is made of. */
#define _GNU_SOURCE    /* O_TMPFILE, mremap */
#include "spool.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

struct block {
    size_t bytes;                /* of all, this struct too */
    bool filed;                  /* mapped from a file; else in memory */
    int fd;                      /* of the file; -1: it was closed */
    struct block *next;          /* among those with a file */
    char head[SPOOL_HEAD];
    char text[];
};

static struct {
    pthread_mutex_t lock;        /* guards what follows */
    struct block *first;         /* with a file: as many as there are long texts */
    char *folder;                /* fixed once there are threads */
} spool = { .lock = PTHREAD_MUTEX_INITIALIZER };

void spool_folder(const char *folder)
{
    free(spool.folder);
    spool.folder = folder ? strdup(folder) : NULL;
}

static size_t bytes_of(size_t length)
{
    return sizeof(struct block) + length + 1;
}

static struct block *block_of(char *text)
{
    return (struct block *)(void *)(text - sizeof(struct block));
}

/* A file without a name; some file systems have none but those whose name went. */
static int make_file(void)
{
    char path[4096];
    int fd = open(spool.folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (fd >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL))
        return fd;
    snprintf(path, sizeof path, "%s/spool-XXXXXX", spool.folder);
    fd = mkostemp(path, O_CLOEXEC);
    if (fd >= 0)
        unlink(path);
    return fd;
}

/* The room is taken before it is written: a page for which the disk has none would end the process. */
static bool reserve(int fd, size_t bytes)
{
    return posix_fallocate(fd, 0, (off_t)bytes) == 0;
}

static void enter(struct block *b)
{
    pthread_mutex_lock(&spool.lock);
    b->next = spool.first;
    spool.first = b;
    pthread_mutex_unlock(&spool.lock);
}

static void leave(struct block *b)
{
    pthread_mutex_lock(&spool.lock);
    struct block **at = &spool.first;
    while (*at != b)
        at = &(*at)->next;
    *at = b->next;
    pthread_mutex_unlock(&spool.lock);
}

static struct block *in_file(size_t bytes)
{
    int fd = spool.folder ? make_file() : -1;
    void *at = fd >= 0 && reserve(fd, bytes) ? mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0) : MAP_FAILED;
    if (at == MAP_FAILED) {
        if (fd >= 0)
            close(fd);
        return NULL;
    }
    struct block *b = at;
    b->bytes = bytes;
    b->filed = true;
    b->fd = fd;
    enter(b);
    return b;
}

char *spool_new(size_t length)
{
    if (length > SIZE_MAX / 2)
        return NULL;
    size_t bytes = bytes_of(length);
    struct block *b = length >= SPOOL_LONG ? in_file(bytes) : NULL;
    if (!b && (b = malloc(bytes))) {
        b->bytes = bytes;
        b->filed = false;
        b->fd = -1;
    }
    return b ? b->text : NULL;
}

/* One that stays where it is, in memory or in a file, or NULL. */
static struct block *grown(struct block *b, size_t bytes)
{
    if (!b->filed) {
        struct block *more = realloc(b, bytes);
        if (more)
            more->bytes = bytes;
        return more;
    }
    if (bytes > b->bytes && (b->fd < 0 || !reserve(b->fd, bytes)))
        return NULL;
    leave(b);
    void *at = mremap(b, b->bytes, bytes, MREMAP_MAYMOVE);
    struct block *more = at == MAP_FAILED ? NULL : at;
    if (more)
        more->bytes = bytes;
    enter(more ? more : b);
    return more;
}

char *spool_resize(char *text, size_t length)
{
    struct block *b = block_of(text);
    bool crosses = !b->filed && length >= SPOOL_LONG && spool.folder;
    struct block *same = length > SIZE_MAX / 2 || crosses ? NULL : grown(b, bytes_of(length));
    if (same)
        return same->text;
    char *other = spool_new(length);
    if (!other)
        return NULL;
    size_t had = b->bytes - sizeof *b;
    memcpy(block_of(other)->head, b->head, sizeof b->head);
    memcpy(other, text, had < length + 1 ? had : length + 1);
    spool_free(text);
    return other;
}

void spool_free(char *text)
{
    if (!text)
        return;
    struct block *b = block_of(text);
    if (!b->filed) {
        free(b);
        return;
    }
    leave(b);
    spool_settle(text);
    munmap(b, b->bytes);
}

void spool_settle(char *text)
{
    struct block *b = block_of(text);
    if (b->filed && b->fd >= 0)
        close(b->fd);
    b->fd = -1;
}

/* Whole pages only: what stands beside them may be in use. */
void spool_rest(const void *at, size_t length)
{
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), from = ((uintptr_t)at + page - 1) / page * page, to = ((uintptr_t)at + length) / page * page;
    if (from >= to)
        return;
    pthread_mutex_lock(&spool.lock);
    for (struct block *b = spool.first; b; b = b->next)
        if (from >= (uintptr_t)b && to <= (uintptr_t)b + b->bytes)
            madvise((void *)from, to - from, MADV_DONTNEED);
    pthread_mutex_unlock(&spool.lock);
}
