/* Those who wait for jobs. Suspending and linking happen under the lock, and so does
 * resuming: a connection is resumed exactly once for each time it was suspended. */
#include "config.h"
#include "jobs_parts.h"
#include "budget.h"
#include "clock.h"
#include "store.h"
#include "waiter.h"

#include <assert.h>
#include <stdlib.h>

static const double RETRY_SECONDS = 1;     /* of a store that fails */

static bool satisfied(const struct job *job, const struct waiter *w)
{
    if (job->gone && w->kind != WAIT_EVENT)
        return true;
    switch (w->kind) {
    case WAIT_STORED: return job->stored != 0 && !job->joining;
    case WAIT_ENDED: return job->finished != NULL;
    default: return job->event != w->seen;
    }
}

/* The bound is on what clients hold open. The disk always answers, so who waits for it
 * is not counted; a stream took its place when it began. */
static bool room(const struct jobs *js, const struct waiter *w)
{
    return w->kind != WAIT_ENDED || ((!w->account || quota_may_wait(w->account)) && js->waiters < (unsigned long)js->config->waiters);
}

static void count(struct account *account, unsigned long *kind, long by)
{
    *kind += (unsigned long)by;
    if (account)
        account->waiting += (unsigned long)by;
    assert((long)*kind >= 0 && (!account || (long)account->waiting >= 0));
}

bool jobs_wait(struct jobs *js, struct job *job, struct waiter *w)
{
    pthread_mutex_lock(&js->lock);
    bool wait = !satisfied(job, w) && !js->closed && !(js->brief && w->kind != WAIT_STORED) && !w->left && w->deadline > sga_now() && room(js, w);
    if (wait) {
        assert(!w->waiting);
        w->job = job;
        w->waiting = true;
        w->prev = NULL;
        w->next = job->waiters;
        if (w->next)
            w->next->prev = w;
        job->waiters = w;
        w->all_prev = NULL;
        w->all_next = js->all;
        if (w->all_next)
            w->all_next->all_prev = w;
        js->all = w;
        if (w->kind == WAIT_ENDED)
            count(w->account, &js->waiters, 1);
        js->hooks.suspend(w->connection);
    }
    pthread_mutex_unlock(&js->lock);
    return wait;
}

enum stream_room jobs_stream_begin(struct jobs *js, struct account *account)
{
    pthread_mutex_lock(&js->lock);
    enum stream_room found = js->streams >= (unsigned long)js->config->streams ? STREAMS_FULL
                             : account && !quota_may_wait(account)             ? STREAM_QUOTA
                                                                               : STREAM_TAKEN;
    if (found == STREAM_TAKEN)
        count(account, &js->streams, 1);
    pthread_mutex_unlock(&js->lock);
    return found;
}

void jobs_stream_end(struct jobs *js, struct account *account)
{
    pthread_mutex_lock(&js->lock);
    count(account, &js->streams, -1);
    pthread_mutex_unlock(&js->lock);
}

static void resume(struct jobs *js, struct waiter *w)
{
    assert(w->waiting && js->all);           /* once for each time it was suspended */
    *(w->prev ? &w->prev->next : &w->job->waiters) = w->next;
    if (w->next)
        w->next->prev = w->prev;
    *(w->all_prev ? &w->all_prev->all_next : &js->all) = w->all_next;
    if (w->all_next)
        w->all_next->all_prev = w->all_prev;
    w->waiting = false;
    if (w->kind == WAIT_ENDED)
        count(w->account, &js->waiters, -1);
    js->hooks.resume(w->connection);
}

void jobs_notify(struct jobs *js, struct job *job)
{
    for (struct waiter *w = job->waiters, *next; w; w = next) {
        next = w->next;
        if (satisfied(job, w))
            resume(js, w);
    }
}

static int64_t days_ago(long days)
{
    return days ? clock_ms() - days * (int64_t)86400000 : 0;
}

/* Every second jobs by age; all else ten times more rarely, since that counts what is kept. */
static void prune(struct jobs *js)
{
    const struct config *c = js->config;
    struct store_keep k = { .since = days_ago(c->keep_days) };
    if (js->prunes++ % 10 == 0)
        k = (struct store_keep){ k.since, c->keep_jobs, c->keep_bytes, days_ago(c->cache_days), c->cache_results };
    if (k.since || k.jobs || k.bytes || k.results_since || k.results)
        store_prune(js->store, &k);
}

void jobs_tick(struct jobs *js, double now)
{
    pthread_mutex_lock(&js->lock);
    bool look = now >= js->retry_at;
    for (struct waiter *w = js->all, *next; w; w = next) {
        next = w->all_next;
        w->left = look && w->kind == WAIT_ENDED && js->hooks.left(w->connection);
        if (w->deadline <= now || w->left)
            resume(js, w);
    }
    if (look) {
        js->retry_at = now + RETRY_SECONDS;
        store_look(js->store);
        if (!store_healthy(js->store))
            store_probe(js->store);
        jobs_save_again(js);
        prune(js);
    }
    pthread_mutex_unlock(&js->lock);
}

void jobs_close_waiters(struct jobs *js)
{
    shared_stop(js);
    pthread_mutex_lock(&js->lock);
    js->closed = true;
    while (js->all)
        resume(js, js->all);
    pthread_mutex_unlock(&js->lock);
}

void jobs_leave_waiters(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    js->brief = true;
    for (struct waiter *w = js->all, *next; w; w = next) {
        next = w->all_next;
        if (w->kind != WAIT_STORED)
            resume(js, w);
    }
    pthread_mutex_unlock(&js->lock);
}

static void barrier_done(void *ctx, enum store_kept how)
{
    bool ok = how == STORE_KEPT;
    struct job *job = ctx;
    struct jobs *js = job->table;
    pthread_mutex_lock(&js->lock);
    job->stored = ok ? 1 : -1;
    jobs_notify(js, job);
    pthread_mutex_unlock(&js->lock);
    job_unref(job);
}

struct job *jobs_barrier(struct jobs *js)
{
    struct job *job = jobs_make(js, "", js->everyone);
    if (!job)
        return NULL;
    job_ref(job);
    if (store_barrier(js->store, barrier_done, job))
        return job;
    free(job);
    return NULL;
}
