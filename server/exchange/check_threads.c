/* A bounded queue of exchanges and two threads. A suspended exchange is not freed, and nobody
 * else looks at it until it is resumed. */
#include "check_threads.h"
#include "exchange.h"
#include "run.h"

#include <pthread.h>
#include <stdlib.h>

enum { THREADS = 2, MOST = 64 };

struct check_threads {
    pthread_mutex_t lock;            /* guards all below but the threads */
    pthread_cond_t work;
    struct exchange *first, **last;
    int count;
    bool closed;
    pthread_t thread[THREADS];
    int threads;
};

static struct exchange *next(struct check_threads *cs)
{
    pthread_mutex_lock(&cs->lock);
    while (!cs->first && !cs->closed)
        pthread_cond_wait(&cs->work, &cs->lock);
    struct exchange *e = cs->first;
    if (e) {
        cs->first = e->check.next;
        if (!cs->first)
            cs->last = &cs->first;
        cs->count--;
    }
    pthread_mutex_unlock(&cs->lock);
    return e;
}

static void *work(void *arg)
{
    struct check_threads *cs = arg;
    for (struct exchange *e; (e = next(cs));) {
        e->check.ok = sga_canonical((const char *)e->body, e->length, &e->check.canonical, &e->check.err);
        e->check.done = true;
        MHD_resume_connection(e->connection);     /* from here on it is another thread's */
    }
    return NULL;
}

struct check_threads *check_threads_new(void)
{
    struct check_threads *cs = calloc(1, sizeof *cs);
    if (!cs)
        return NULL;
    pthread_mutex_init(&cs->lock, NULL);
    pthread_cond_init(&cs->work, NULL);
    cs->last = &cs->first;
    while (cs->threads < THREADS && pthread_create(&cs->thread[cs->threads], NULL, work, cs) == 0)
        cs->threads++;
    if (cs->threads > 0)
        return cs;
    check_threads_free(cs);
    return NULL;
}

bool check_threads_submit(struct check_threads *cs, struct exchange *e)
{
    pthread_mutex_lock(&cs->lock);
    bool taken = !cs->closed && cs->count < MOST;
    if (taken) {
        conn_deadline(e->conn, 0);
        MHD_suspend_connection(e->connection);
        e->check.next = NULL;
        *cs->last = e;
        cs->last = &e->check.next;
        cs->count++;
        pthread_cond_signal(&cs->work);
    }
    pthread_mutex_unlock(&cs->lock);
    return taken;
}

void check_threads_close(struct check_threads *cs)
{
    pthread_mutex_lock(&cs->lock);
    cs->closed = true;
    struct exchange *e = cs->first;
    cs->first = NULL;
    cs->last = &cs->first;
    cs->count = 0;
    pthread_cond_broadcast(&cs->work);
    pthread_mutex_unlock(&cs->lock);
    for (struct exchange *after; e; e = after) {
        after = e->check.next;
        sga_fail(&e->check.err, SGA_E_DRAINING, "The service is shutting down. Try again later.");
        e->check.done = true;
        MHD_resume_connection(e->connection);
    }
    for (int i = 0; i < cs->threads; i++)
        pthread_join(cs->thread[i], NULL);
    cs->threads = 0;
}

void check_threads_free(struct check_threads *cs)
{
    if (!cs)
        return;
    pthread_cond_destroy(&cs->work);
    pthread_mutex_destroy(&cs->lock);
    free(cs);
}
