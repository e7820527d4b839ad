/* The list of connections, and the reaper. A cut is a shutdown(): the HTTP library then
 * sees the end of the stream and closes by its own rules. */
#include "conns.h"
#include "front.h"

#include <assert.h>
#include <netinet/in.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

struct conn {
    struct front *front;
    int fd;
    _Atomic double deadline;
    atomic_bool rests, busy;
    int door;
    bool cut;                    /* it gave its place; below, as it is the list's */
    unsigned char from[16];      /* an address; all zero: not told apart */
    struct conn *prev, *next;
};

struct conns {
    pthread_mutex_t lock;        /* guards the list, and that a descriptor in it is open */
    struct conn *first;          /* the latest */
    unsigned long count;
    const atomic_long *at_door, *from_address;
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
    assert(cs->count == 0);
    pthread_mutex_destroy(&cs->lock);
    free(cs);
}

void conns_limit(struct conns *cs, const atomic_long *at_door, const atomic_long *from_address)
{
    cs->at_door = at_door;
    cs->from_address = from_address;
}

static void read_address(const struct sockaddr *a, unsigned char out[16])
{
    if (a && a->sa_family == AF_INET) {
        memcpy(out, "\0\0\0\0\0\0\0\0\0\0\xff\xff", 12);      /* as IPv6 has it */
        memcpy(out + 12, &((const struct sockaddr_in *)a)->sin_addr, 4);
    } else if (a && a->sa_family == AF_INET6) {
        memcpy(out, &((const struct sockaddr_in6 *)a)->sin6_addr, 16);
    }
}

/* Under the lock, before c is in the list. Is there a place for it, or one that another gives? */
static bool make_room(struct conns *cs, const struct conn *c, bool *gave)
{
    static const unsigned char nobody[16];
    unsigned long most[2] = { cs->from_address ? (unsigned long)*cs->from_address : 0, cs->at_door ? (unsigned long)*cs->at_door : 0 }, count[2] = { 0, 0 };
    struct conn *idle[2] = { NULL, NULL };
    bool alike = most[0] && memcmp(c->from, nobody, sizeof nobody) != 0;
    if ((!alike || cs->count < most[0]) && (!most[1] || cs->count < most[1]))
        return true;
    for (struct conn *o = cs->first; o; o = o->next) {
        bool same[2] = { alike && o->door == c->door && memcmp(o->from, c->from, sizeof c->from) == 0, o->door == c->door };
        for (int i = 0; i < 2; i++) {
            count[i] += same[i] && !o->cut;
            if (same[i] && !o->cut && !atomic_load(&o->busy))
                idle[i] = o;                /* the last that is met is the oldest */
        }
    }
    assert(count[1] <= cs->count && count[0] <= count[1]);
    for (int i = 0; i < 2; i++) {
        if (!most[i] || count[i] < most[i])
            continue;
        if (!idle[i])
            return false;
        idle[i]->cut = true;
        shutdown(idle[i]->fd, SHUT_RDWR);
        *gave = true;
        return true;
    }
    return true;
}

struct conn *conn_add(struct conns *cs, int fd, void *session, int door, const struct sockaddr *from, double deadline, bool *gave)
{
    struct conn *c = calloc(1, sizeof *c);
    if (!c || !(c->front = front_open(fd, session, c))) {
        free(c);
        return NULL;
    }
    c->fd = fd;
    c->door = door;
    read_address(from, c->from);
    *gave = false;
    atomic_init(&c->deadline, deadline);
    pthread_mutex_lock(&cs->lock);
    if (!make_room(cs, c, gave)) {
        pthread_mutex_unlock(&cs->lock);
        front_close(c->front);
        free(c);
        return NULL;
    }
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
    assert(cs->count > 0 && (c->prev ? c->prev->next == c : cs->first == c));
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
    if (!c)
        return;
    atomic_store(&c->rests, !busy);
    atomic_store(&c->busy, busy);
}

int conns_cut_resting(struct conns *cs)
{
    int cut = 0;
    pthread_mutex_lock(&cs->lock);
    for (struct conn *c = cs->first; c; c = c->next)
        if (atomic_load(&c->rests)) {
            shutdown(c->fd, SHUT_RD);        /* a request that is here already is read before this end, and answered */
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
