/* The table of living jobs: making, finding, submitting. */
#include "config.h"
#include "finished.h"
#include "jobs_parts.h"
#include "budget.h"
#include "clock.h"
#include "log.h"
#include "memory_cache.h"
#include "metrics.h"
#include "no_memory.h"
#include "store.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"

struct jobs *jobs_new(const struct config *c, struct store *st, struct memory_cache *memory_cache, struct metrics *m, struct jobs_hooks hooks)
{
    struct jobs *js = calloc(1, sizeof *js);
    if (!js)
        return NULL;
    js->config = c;
    js->store = st;
    js->memory_cache = memory_cache;
    js->metrics = m;
    js->hooks = hooks;
    js->shared = store_shared(st);
    pthread_mutex_init(&js->lock, NULL);
    pthread_cond_init(&js->work, NULL);
    static const struct quota none;
    if ((js->everyone = jobs_account(js, "", &none)))
        return js;
    jobs_free(js);
    return NULL;
}

struct job *jobs_make(struct jobs *js, const char *id, struct account *account)
{
    struct job *job = calloc(1, sizeof *job);
    if (!job)
        return NULL;
    atomic_init(&job->refs, 1);
    snprintf(job->row.id, sizeof job->row.id, "%s", id);
    snprintf(job->progress.stage, sizeof job->progress.stage, "queued");
    job->event = 1;
    job->wake_fd = -1;
    job->stage = STAGE_NONE;
    job->account = account;
    snprintf(job->row.owner, sizeof job->row.owner, "%s", account->name);
    job->table = js;
    return job;
}

void job_ref(struct job *job)
{
    atomic_fetch_add(&job->refs, 1);
}

void job_unref(struct job *job)
{
    if (!job || atomic_fetch_sub(&job->refs, 1) != 1)
        return;
    free(job->row.error);
    free(job->end.error);
    free(job->order);
    free(job->request);
    jobs_free_interests(job);
    finished_unref(job->ending);
    finished_unref(job->finished);
    free(job);
}

const char *job_id(const struct job *job)
{
    return job->row.id;
}

const struct account *job_account(const struct job *job)
{
    return job->account;
}

struct job **jobs_place(struct jobs *js, const char *id)
{
    unsigned h = 2166136261u;
    for (int i = 0; i < ID_LENGTH; i++)
        h = (h ^ (unsigned char)id[i]) * 16777619u;
    struct job **j = &js->bucket[h % JOBS_BUCKETS];
    while (*j && memcmp((*j)->row.id, id, ID_LENGTH) != 0)
        j = &(*j)->chain;
    return j;
}

/* The table's own reference goes with it. */
static void forget(struct job **at)
{
    struct job *job = *at;
    assert(!job->waiters);                   /* they were resumed before: each has its connection suspended */
    *at = job->chain;
    job->chain = NULL;
    job_unref(job);
}

/* The row of a new job is on disk, or could not be put there. */
static void stored(void *ctx, enum store_kept how)
{
    bool ok = how == STORE_KEPT;
    struct job *job = ctx;
    struct jobs *js = job->table;
    bool lost = false;
    pthread_mutex_lock(&js->lock);
    job->stored = ok ? 1 : -1;
    free(job->order);
    job->order = NULL;
    if (!ok && job->queued) {
        jobs_dequeue(js, job);
        lost = true;
    }
    jobs_notify(js, job);
    pthread_mutex_unlock(&js->lock);
    if (lost) {
        struct sga_error err = { .code = SGA_E_STORE, .stage = "queue" };
        snprintf(err.detail, sizeof err.detail, "The job could not be written to the store.");
        jobs_end(js, job, JOB_FAILED, &err, NULL, 0);
    }
    job_unref(job);
}

/* Memory has decided: no bounds. The store has a reference until stored() gives it back. */
static bool order(struct jobs *js, struct job *fresh, const struct submission *s)
{
    if (!(fresh->order = calloc(1, sizeof *fresh->order)))
        return false;
    *fresh->order = (struct store_submission){ .row = fresh->row, .request = { s->request, s->length }, .join = !s->owner, .again = true };
    job_ref(fresh);
    if (store_submit(js->store, fresh->order, stored, fresh))
        return true;
    atomic_fetch_sub(&fresh->refs, 1);      /* the store's, never the last */
    return false;
}

static bool no_room(const struct jobs *js, size_t length)
{
    return js->queue_count >= (unsigned long)js->config->queue
        || js->queue_bytes + length > (unsigned long)js->config->queue_bytes;
}

/* No token takes more than its share of the queue, whatever its own quotas are. */
static bool over_share(const struct jobs *js, struct submission *s)
{
    double share = 0.01 * (double)js->config->token_queue;
    bool over = s->account != js->everyone && (double)s->account->alive + 1 > share * (double)js->config->queue + 1;
    if (over) {
        s->quota = "places in the queue";
        s->retry = 5;
    }
    return over;
}

static enum submit submit_new(struct jobs *js, struct submission *s)
{
    double seconds = jobs_seconds(js->config, s->request, s->length);
    if (no_room(js, s->length))
        return SUBMIT_FULL;
    if (over_share(js, s) || (s->quota = quota_full(s->account, s->length, seconds, sga_now(), &s->retry)))
        return SUBMIT_QUOTA;
    struct job *fresh = jobs_make(js, s->id, s->account);
    if (!fresh)
        return SUBMIT_NO_MEMORY;
    fresh->row.created = clock_ms();
    if (s->owner)
        snprintf(fresh->row.owner, sizeof fresh->row.owner, "%s", s->owner);
    snprintf(fresh->request_id, sizeof fresh->request_id, "%s", s->request_id);
    snprintf(fresh->traceparent, sizeof fresh->traceparent, "%s", s->traceparent);
    fresh->row.seconds = (int64_t)seconds + 1;
    if (!s->owner)
        jobs_add_interest(fresh, s->account);
    fresh->row.epoch = store_epoch(js->store);
    if (!order(js, fresh, s)) {
        job_unref(fresh);
        return SUBMIT_NO_MEMORY;
    }
    fresh->request = s->request;
    fresh->request_length = s->length;
    s->request = NULL;
    struct job **at = jobs_place(js, s->id);
    assert(!*at);                            /* one job for each id */
    *at = fresh;
    memory_cache_drop(js->memory_cache, s->id);
    job_ref(fresh);            /* the caller's */
    s->job = fresh;
    fresh->account->alive++;
    fresh->account->accepted++;
    fresh->account->reserved += (double)fresh->row.seconds;
    jobs_enqueue(js, fresh);
    metrics_add(js->metrics, METRIC_JOBS_NEW);
    return SUBMIT_NEW;
}

enum submit jobs_submit(struct jobs *js, struct submission *s)
{
    enum submit outcome;
    pthread_mutex_lock(&js->lock);
    struct job *old = *jobs_place(js, s->id);
    struct finished *f = old ? NULL : memory_cache_by_id(js->memory_cache, s->id);
    if (f && f->status == JOB_DONE) {
        s->finished = f;
        f = NULL;
        outcome = SUBMIT_DONE;
    } else if (js->draining) {
        outcome = SUBMIT_DRAINING;
    } else if (old) {
        job_ref(old);
        s->job = old;
        if (!s->owner)
            jobs_join(js, old, s->account);
        outcome = SUBMIT_JOINED;
        metrics_add(js->metrics, METRIC_JOBS_JOINED);
    } else {
        outcome = js->shared ? shared_submit(js, s) : submit_new(js, s);
        s->account->refused += outcome == SUBMIT_QUOTA || outcome == SUBMIT_FULL;
    }
    pthread_mutex_unlock(&js->lock);
    finished_unref(f);
    return outcome;
}

struct job *jobs_find(struct jobs *js, const char *id)
{
    pthread_mutex_lock(&js->lock);
    struct job *job = *jobs_place(js, id);
    if (job)
        job_ref(job);
    pthread_mutex_unlock(&js->lock);
    return job;
}

void jobs_look(struct jobs *js, struct job *job, struct job_look *look)
{
    pthread_mutex_lock(&js->lock);
    *look = (struct job_look){ .row = job->row, .progress = job->progress, .event = job->event,
                               .finished = finished_ref(job->finished), .stored = job->joining ? 0 : job->stored,
                               .gone = job->gone, .refused = job->refused, .quota = job->quota, .retry = job->retry };
    look->row.error = NULL;
    pthread_mutex_unlock(&js->lock);
}

/* Each account's queue is in order but for what went back to its front, which is older still. */
static double oldest(const struct jobs *js)
{
    int64_t first = 0;
    for (const struct account *a = js->accounts; a; a = a->next)
        if (a->front && (!first || a->front->row.created < first))
            first = a->front->row.created;
    int64_t now = first ? clock_ms() : 0;
    return now > first ? 1e-3 * (double)(now - first) : 0;
}

void jobs_count(struct jobs *js, struct jobs_counts *out)
{
    pthread_mutex_lock(&js->lock);
    *out = (struct jobs_counts){ js->queue_count, js->running, js->queue_bytes, js->waiters, js->streams, js->ending, js->ending_bytes, oldest(js), no_room(js, 0),
                                 js->unable >= atomic_load(&js->config->workers) };
    pthread_mutex_unlock(&js->lock);
}

/* A queued job of an earlier life, on its owner's account: the quota follows once the tokens
 * are read. Its request stays on disk until it runs. */
static void recover_one(void *ctx, const struct job_row *row)
{
    static const struct quota none;
    struct jobs *js = ctx;
    struct account *account = jobs_account(js, row->owner, &none);
    struct job *job = account ? jobs_make(js, row->id, account) : NULL;
    if (!job)
        no_memory("the queue that was found");
    job->row = *row;
    job->row.error = NULL;
    job->stored = 1;
    bool again = row->attempts < JOBS_TRIES;
    jobs_load_interests(js, job);
    pthread_mutex_lock(&js->lock);    /* the end of an earlier one may come from the disk meanwhile */
    *jobs_place(js, row->id) = job;
    job->account->alive++;
    job->account->reserved += (double)job->row.seconds;
    if (again)
        jobs_enqueue(js, job);
    pthread_mutex_unlock(&js->lock);
    if (again)
        return;
    struct sga_error err = { .code = SGA_E_WORKER_DIED, .stage = "queue" };
    snprintf(err.detail, sizeof err.detail, "The service ended %d times while this job ran; it is not tried again.", row->attempts);
    jobs_end(js, job, JOB_FAILED, &err, NULL, 0);
}

static void recover_used(void *ctx, const char *owner, int64_t ms)
{
    static const struct quota none;
    struct jobs *js = ctx;
    struct account *account = jobs_account_of(js, owner ? owner : "", &none);
    if (account && ms > 0)
        jobs_charge(js, account, 1e-3 * (double)ms);
}

bool jobs_recover(struct jobs *js, char *why, size_t size)
{
    if (js->shared)
        return shared_start(js, why, size);
    if (!store_recover(js->store, recover_one, js, why, size))
        return false;
    if (!store_used(js->store, clock_ms() - 1000 * (int64_t)ACCOUNT_HOUR, recover_used, js)) {
        snprintf(why, size, "the queue cannot be read");
        return false;
    }
    if (js->queue_count) {
        char count[32];
        snprintf(count, sizeof count, "%lu", js->queue_count);
        log_event(LOG_L_INFO, "jobs_recovered", "#count", count, NULL);
    }
    return true;
}

void jobs_free(struct jobs *js)
{
    if (!js)
        return;
    for (int i = 0; i < JOBS_BUCKETS; i++)
        while (js->bucket[i])
            forget(&js->bucket[i]);
    for (struct account *a = js->accounts, *next; a; a = next) {
        next = a->next;
        free(a);
    }
    free(js->cancelled_text);
    free(js->died_text);
    pthread_cond_destroy(&js->work);
    pthread_mutex_destroy(&js->lock);
    free(js);
}
