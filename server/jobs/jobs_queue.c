/* The queue: one first-in-first-out list for each account, and a ring of the accounts that
 * have jobs in theirs. Workers take one job from each in turn, so that a thousand jobs of
 * one user delay another's first by one job, not by a thousand. */
#include "config.h"
#include "jobs_parts.h"
#include "budget.h"
#include "metrics.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void enter_ring(struct jobs *js, struct account *a)
{
    assert(!a->ring_next && !a->back);
    if (!js->turn) {
        a->ring_next = a->ring_prev = js->turn = a;
        return;
    }
    a->ring_next = js->turn;              /* just served last: the end of the round */
    a->ring_prev = js->turn->ring_prev;
    a->ring_prev->ring_next = a;
    js->turn->ring_prev = a;
}

static void leave_ring(struct jobs *js, struct account *a)
{
    assert(js->turn && a->ring_next && !a->back);
    if (a->ring_next == a) {
        js->turn = NULL;
    } else {
        a->ring_next->ring_prev = a->ring_prev;
        a->ring_prev->ring_next = a->ring_next;
        if (js->turn == a)
            js->turn = a->ring_next;
    }
    a->ring_next = a->ring_prev = NULL;
}

void jobs_stage(struct job *job, enum metrics_stage stage)
{
    double now = sga_now();
    if (stage == job->stage)
        return;
    metrics_moved(job->table->metrics, job->stage, stage, now - job->stage_since);
    job->stage = stage;
    job->stage_since = now;
}

static void entered(struct jobs *js, struct job *job)
{
    assert(!job->queued && job->row.status == JOB_QUEUED && !job->ending && job->wake_fd < 0);
    job->account->bytes += job->request_length;
    job->queued = true;
    jobs_stage(job, STAGE_QUEUED);
    js->queue_count++;
    js->queue_bytes += job->request_length;
    pthread_cond_signal(&js->work);
}

void jobs_enqueue(struct jobs *js, struct job *job)
{
    struct account *a = job->account;
    if (!a->front)
        enter_ring(js, a);
    job->ahead = a->back;
    job->behind = NULL;
    *(a->back ? &a->back->behind : &a->front) = job;
    a->back = job;
    entered(js, job);
}

void jobs_enqueue_first(struct jobs *js, struct job *job)
{
    struct account *a = job->account;
    if (!a->front)
        enter_ring(js, a);
    job->behind = a->front;
    job->ahead = NULL;
    *(a->front ? &a->front->ahead : &a->back) = job;
    a->front = job;
    entered(js, job);
}

void jobs_dequeue(struct jobs *js, struct job *job)
{
    struct account *a = job->account;
    assert(job->queued && js->queue_count > 0 && js->queue_bytes >= job->request_length && a->bytes >= job->request_length);
    *(job->ahead ? &job->ahead->behind : &a->front) = job->behind;
    *(job->behind ? &job->behind->ahead : &a->back) = job->ahead;
    a->bytes -= job->request_length;
    if (!a->front)
        leave_ring(js, a);
    job->queued = false;
    js->queue_count--;
    js->queue_bytes -= job->request_length;
}

static bool may_run(const struct jobs *js, const struct account *a)
{
    long workers = js->config->workers, share = workers * js->config->token_workers / 100;
    return a == js->everyone || a->running < (unsigned long)(share > 1 ? share : 1);
}

/* Of those whose turn it is, the first that may have one more worker. */
struct job *jobs_next(struct jobs *js)
{
    struct account *a = js->turn;
    for (bool round = false; a && !may_run(js, a); round = true, a = a->ring_next)
        if (round && a == js->turn)
            return NULL;
    if (!a)
        return NULL;
    struct job *job = a->front;
    assert(job && job->account == a);        /* the ring has those with a queue */
    js->turn = a->ring_next;
    jobs_dequeue(js, job);
    return job;
}

void jobs_settle(struct job *job, double seconds)
{
    jobs_stage(job, STAGE_NONE);
    assert(job->account->alive > 0 && job->account->reserved >= (double)job->row.seconds);      /* whole numbers: they add up exactly */
    job->account->alive--;
    job->account->reserved -= (double)job->row.seconds;
    if (!job->table->shared)         /* else the store counts them */
        quota_ran(job->account, seconds, sga_now());
}

void jobs_charge(struct jobs *js, struct account *account, double seconds)
{
    pthread_mutex_lock(&js->lock);
    quota_ran(account, seconds, sga_now());
    pthread_mutex_unlock(&js->lock);
}

/* Under the lock. */
static struct account *account_named(struct jobs *js, const char *name, const struct quota *quota, bool set)
{
    struct account *a = js->accounts;
    while (a && strcmp(a->name, name) != 0)
        a = a->next;
    bool fresh = !a;
    if (fresh && (a = calloc(1, sizeof *a))) {
        snprintf(a->name, sizeof a->name, "%s", name);
        a->next = js->accounts;
        js->accounts = a;
    }
    if (a && (fresh || set))
        a->quota = *quota;
    return a;
}

struct account *jobs_account(struct jobs *js, const char *name, const struct quota *quota)
{
    pthread_mutex_lock(&js->lock);
    struct account *a = account_named(js, name, quota, true);
    pthread_mutex_unlock(&js->lock);
    return a;
}

struct account *jobs_account_of(struct jobs *js, const char *name, const struct quota *quota)
{
    pthread_mutex_lock(&js->lock);
    struct account *a = account_named(js, name, quota, false);
    pthread_mutex_unlock(&js->lock);
    return a;
}
