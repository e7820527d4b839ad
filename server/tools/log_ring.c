/* The ring: whoever logs puts whole lines in under a lock that is held for a copy; one thread
 * takes bytes out and writes them without the lock. Invariant: the bytes from `at` on, `used` of
 * them and round the end, are whole lines but for a first one that is half written. */
#define _GNU_SOURCE    /* pthread_cond_clockwait */
#include "log_ring.h"
#include "log.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { CLOSE_SECONDS = 1, PIECE = 1 << 16 };

static struct {
    pthread_mutex_t lock;            /* guards all but dropped */
    pthread_cond_t work, empty;
    char bytes[LOG_RING];
    size_t at, used;
    unsigned long told;              /* of the dropped lines, how many a line has told of */
    bool running, stop;
    atomic_ulong dropped;
    pthread_t thread;
} ring = { .lock = PTHREAD_MUTEX_INITIALIZER, .work = PTHREAD_COND_INITIALIZER, .empty = PTHREAD_COND_INITIALIZER };

unsigned long log_dropped(void)
{
    return atomic_load(&ring.dropped);
}

/* Whether it stays so or not: a full pipe that does not block (EAGAIN) is waited for. */
static size_t write_some(const char *bytes, size_t length)
{
    ssize_t n = write(STDERR_FILENO, bytes, length);
    if (n >= 0)
        return (size_t)n;
    if (errno == EINTR)
        return 0;
    if (errno != EAGAIN)
        return length;               /* closed or full for good: the line is lost, the service goes on */
    struct pollfd p = { .fd = STDERR_FILENO, .events = POLLOUT };
    poll(&p, 1, 1000);
    return 0;
}

static void append(const char *line, size_t length)
{
    size_t to = (ring.at + ring.used) % LOG_RING, first = length < LOG_RING - to ? length : LOG_RING - to;
    memcpy(ring.bytes + to, line, first);
    memcpy(ring.bytes, line + first, length - first);
    ring.used += length;
}

/* Under the lock, by the thread that writes: bytes that follow each other. */
static size_t take(char *piece)
{
    size_t n = ring.used < LOG_RING - ring.at ? ring.used : LOG_RING - ring.at;
    n = n < PIECE ? n : PIECE;
    memcpy(piece, ring.bytes + ring.at, n);
    return n;
}

static void *bring_out(void *unused)
{
    static char piece[PIECE];
    (void)unused;
    pthread_mutex_lock(&ring.lock);
    for (;;) {
        while (!ring.used && !ring.stop)
            pthread_cond_wait(&ring.work, &ring.lock);
        if (!ring.used)
            break;
        size_t n = take(piece);
        pthread_mutex_unlock(&ring.lock);
        n = write_some(piece, n);
        pthread_mutex_lock(&ring.lock);
        ring.at = (ring.at + n) % LOG_RING;
        ring.used -= n;
    }
    ring.running = false;
    pthread_cond_signal(&ring.empty);
    pthread_mutex_unlock(&ring.lock);
    return NULL;
}

void log_ring_open(void)
{
    ring.running = pthread_create(&ring.thread, NULL, bring_out, NULL) == 0;
    if (ring.running)
        pthread_detach(ring.thread);
}

/* Room for a line, and for the one that tells of those dropped before. */
static bool room(size_t length)
{
    enum { TELLING = 256 };
    return ring.used + length + TELLING <= LOG_RING;
}

void log_ring_put(const char *line, size_t length)
{
    unsigned long untold = 0;
    pthread_mutex_lock(&ring.lock);
    bool direct = !ring.running, fits = !direct && room(length);
    if (fits) {
        append(line, length);
        untold = atomic_load(&ring.dropped) - ring.told;
        ring.told += untold;
        pthread_cond_signal(&ring.work);
    } else if (!direct) {
        atomic_fetch_add(&ring.dropped, 1);
    }
    pthread_mutex_unlock(&ring.lock);
    if (direct)
        write_some(line, length);
    if (!untold)
        return;
    char count[32];
    snprintf(count, sizeof count, "%lu", untold);
    log_event(LOG_L_WARN, "log_dropped", "#count", count, NULL);
}

void log_close(void)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += CLOSE_SECONDS;
    pthread_mutex_lock(&ring.lock);
    ring.stop = true;
    pthread_cond_signal(&ring.work);
    while (ring.running && pthread_cond_clockwait(&ring.empty, &ring.lock, CLOCK_MONOTONIC, &until) == 0)
        ;
    pthread_mutex_unlock(&ring.lock);
}
