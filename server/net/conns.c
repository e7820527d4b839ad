/* The list of connections, and the reaper. A cut is a shutdown(): the HTTP library then
 * sees the end of the stream and closes by its own rules. */
#include "conns.h"
#include "front.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/socket.h>

struct conn {
    struct front *front;
    int fd;
    _Atomic double deadline;
    atomic_bool rests;
    struct conn *prev, *next;
};

struct conns {
    pthread_mutex_t lock;        /* guards the list, and that a descriptor in it is open */
    struct conn *first;
    unsigned long count;
};

struct conns *conns_new(void)
{
    struct conns *cs = calloc(1, sizeof *cs);
    if (cs)
        pthread_mutex_init(&cs->lock, NULL);
    return cs;
}

void conns_free(struct conns *cs)
{
    if (!cs)
        return;
    while (cs->first)
        conn_remove(cs, cs->first);
    pthread_mutex_destroy(&cs->lock);
    free(cs);
}

struct conn *conn_add(struct conns *cs, int fd, bool secure, double deadline)
{
    struct conn *c = calloc(1, sizeof *c);
    if (!c || !(c->front = front_open(fd, secure, c))) {
        free(c);
        return NULL;
    }
    c->fd = fd;
    atomic_init(&c->deadline, deadline);
    pthread_mutex_lock(&cs->lock);
    c->next = cs->first;
    if (c->next)
        c->next->prev = c;
    cs->first = c;
    cs->count++;
    pthread_mutex_unlock(&cs->lock);
    return c;
}

void conn_remove(struct conns *cs, struct conn *c)
{
    if (!c)
        return;
    pthread_mutex_lock(&cs->lock);
    *(c->prev ? &c->prev->next : &cs->first) = c->next;
    if (c->next)
        c->next->prev = c->prev;
    cs->count--;
    pthread_mutex_unlock(&cs->lock);
    front_close(c->front);
    free(c);
}

struct front *conn_front(struct conn *c)
{
    return c ? c->front : NULL;
}

void conn_deadline(struct conn *c, double deadline)
{
    if (c)
        atomic_store(&c->deadline, deadline);
}

void conn_busy(struct conn *c, bool busy)
{
    if (c)
        atomic_store(&c->rests, !busy);
}

int conns_cut_resting(struct conns *cs)
{
    int cut = 0;
    pthread_mutex_lock(&cs->lock);
    for (struct conn *c = cs->first; c; c = c->next)
        if (atomic_load(&c->rests)) {
            shutdown(c->fd, SHUT_RDWR);
            cut++;
        }
    pthread_mutex_unlock(&cs->lock);
    return cut;
}

int conns_reap(struct conns *cs, double now, int all)
{
    int cut = 0;
    pthread_mutex_lock(&cs->lock);
    for (struct conn *c = cs->first; c; c = c->next) {
        double deadline = atomic_load(&c->deadline);
        if (!all && (deadline == 0 || deadline > now))
            continue;
        shutdown(c->fd, SHUT_RDWR);
        atomic_store(&c->deadline, 0);
        cut++;
    }
    pthread_mutex_unlock(&cs->lock);
    return cut;
}

unsigned long conns_count(struct conns *cs)
{
    pthread_mutex_lock(&cs->lock);
    unsigned long n = cs->count;
    pthread_mutex_unlock(&cs->lock);
    return n;
}
