/* The queue: one first-in-first-out list for each account, and a ring of the accounts that
 * have jobs in theirs. Workers take one job from each in turn, so that a thousand jobs of
 * one user delay another's first by one job, not by a thousand. */
#include "jobs_parts.h"
#include "budget.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void enter_ring(struct jobs *js, struct account *a)
{
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

void jobs_enqueue(struct jobs *js, struct job *job)
{
    struct account *a = job->account;
    if (!a->front)
        enter_ring(js, a);
    job->ahead = a->back;
    job->behind = NULL;
    *(a->back ? &a->back->behind : &a->front) = job;
    a->back = job;
    a->bytes += job->request_length;
    job->queued = true;
    jobs_stage(job, STAGE_QUEUED);
    js->queue_count++;
    js->queue_bytes += job->request_length;
    pthread_cond_signal(&js->work);
}

void jobs_dequeue(struct jobs *js, struct job *job)
{
    struct account *a = job->account;
    *(job->ahead ? &job->ahead->behind : &a->front) = job->behind;
    *(job->behind ? &job->behind->ahead : &a->back) = job->ahead;
    a->bytes -= job->request_length;
    if (!a->front)
        leave_ring(js, a);
    job->queued = false;
    js->queue_count--;
    js->queue_bytes -= job->request_length;
}

struct job *jobs_next(struct jobs *js)
{
    struct account *a = js->turn;
    if (!a)
        return NULL;
    struct job *job = a->front;
    js->turn = a->ring_next;
    jobs_dequeue(js, job);
    return job;
}

void jobs_settle(struct job *job, double seconds)
{
    jobs_stage(job, STAGE_NONE);
    job->account->alive--;
    quota_ran(job->account, seconds, sga_now());
}

struct account *jobs_account(struct jobs *js, const char *name, const struct quota *quota)
{
    pthread_mutex_lock(&js->lock);
    struct account *a = js->accounts;
    while (a && strcmp(a->name, name) != 0)
        a = a->next;
    if (!a && (a = calloc(1, sizeof *a))) {
        snprintf(a->name, sizeof a->name, "%s", name);
        a->next = js->accounts;
        js->accounts = a;
    }
    if (a)
        a->quota = *quota;
    pthread_mutex_unlock(&js->lock);
    return a;
}
