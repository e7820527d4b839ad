/* Running jobs: claiming, progress, going back, cancelling. */
#include "config.h"
#include "jobs_parts.h"
#include "budget.h"
#include "clock.h"
#include "json_scan.h"
#include "metrics.h"
#include "store.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "error.h"

static const double DEFAULT_SECONDS = 30;        /* of a request that sets no limit */

static bool disk_keeps_up(const struct jobs *js)
{
    return js->ending_bytes <= (unsigned long)atomic_load(&js->config->unsaved_memory);
}

struct job *jobs_claim(struct jobs *js, int wake_fd)
{
    if (js->shared)
        return shared_claim(js, wake_fd);
    pthread_mutex_lock(&js->lock);
    struct job *job = NULL;
    while (!js->draining && !js->leaving && !(disk_keeps_up(js) && (job = jobs_next(js))))
        pthread_cond_wait(&js->work, &js->lock);
    if (job) {
        assert(!job->queued && job->wake_fd < 0 && job->row.status == JOB_QUEUED && !job->ending);
        job->account->running++;
        job_ref(job);
        job->row.status = JOB_RUNNING;
        job->row.started = clock_after(job->row.created);
        job->row.epoch = store_epoch(js->store);
        job->began = sga_now();
        snprintf(job->progress.stage, sizeof job->progress.stage, JOB_STAGE_CLAIMED);
        job->wake_fd = wake_fd;
        jobs_stage(job, STAGE_RUNNING);
        job->event++;
        js->running++;
        store_started(js->store, &job->row);
        jobs_notify(js, job);
    }
    pthread_mutex_unlock(&js->lock);
    return job;
}

/* Only the worker that runs the job calls this, so the field is its own meanwhile. */
const char *jobs_request(struct jobs *js, struct job *job, size_t *length)
{
    if (!job->request && store_request(js->store, job->row.id, &job->request, &job->request_length) != STORE_FOUND)
        return NULL;
    *length = job->request_length;
    return job->request;
}

double jobs_seconds(const struct config *c, const char *request, size_t length)
{
    struct slice limits = scan_member(scan_value(request, request + length), "limits");
    double seconds = scan_number(scan_member(limits, "seconds"), DEFAULT_SECONDS), most = (double)c->max_seconds;
    return seconds > 0 && seconds < most ? seconds : most;
}

bool jobs_cancelled(struct jobs *js, struct job *job)
{
    pthread_mutex_lock(&js->lock);
    bool cancel = job->cancel;
    pthread_mutex_unlock(&js->lock);
    return cancel;
}

void jobs_progress(struct jobs *js, struct job *job, const char *stage, double fraction, double t)
{
    pthread_mutex_lock(&js->lock);
    snprintf(job->progress.stage, sizeof job->progress.stage, "%s", stage);
    jobs_stage(job, metrics_stage_of(stage));
    job->progress.fraction = fraction >= 0 && fraction <= 1 ? fraction : 0;
    job->progress.moves = isfinite(t);
    job->progress.t = job->progress.moves ? t : 0;
    job->event++;
    jobs_notify(js, job);
    pthread_mutex_unlock(&js->lock);
}

/* Under the lock. */
static void put_back(struct jobs *js, struct job *job)
{
    if (js->shared) {
        shared_release(js, job);
        return;
    }
    assert(job->row.status == JOB_RUNNING && js->running > 0 && job->account->running > 0);
    job->row.status = JOB_QUEUED;
    job->row.started = 0;
    job->began = 0;
    job->wake_fd = -1;
    job->progress = (struct job_progress){ .stage = "queued" };
    job->event++;
    js->running--;
    job->account->running--;
    jobs_enqueue_first(js, job);
    store_release(js->store, &job->row, &job->row.epoch, NULL, NULL);
    jobs_notify(js, job);
}

static void end_cancelled(struct jobs *js, struct job *job)
{
    struct sga_error err = { .code = SGA_E_CANCELLED, .stage = "queue" };
    snprintf(err.detail, sizeof err.detail, "The job was cancelled before it ran.");
    jobs_end(js, job, JOB_CANCELLED, &err, NULL, 0);
}

void jobs_requeue(struct jobs *js, struct job *job)
{
    pthread_mutex_lock(&js->lock);
    bool cancel = job->cancel;
    if (!cancel)
        put_back(js, job);
    pthread_mutex_unlock(&js->lock);
    if (cancel)
        end_cancelled(js, job);
}

bool jobs_try_again(struct jobs *js, struct job *job)
{
    pthread_mutex_lock(&js->lock);
    bool again = !job->killed && !job->cancel;
    job->killed = true;
    if (again) {
        job->row.attempts++;
        put_back(js, job);
    }
    pthread_mutex_unlock(&js->lock);
    return again;
}

bool jobs_help(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    bool idle = !js->draining && !js->leaving && !js->stopping && js->unable == 0
        && js->running + js->helping < (unsigned long)atomic_load(&js->config->workers);
    js->helping += idle;
    pthread_mutex_unlock(&js->lock);
    return idle;
}

bool jobs_help_over(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    bool over = js->stopping || js->running + js->helping > (unsigned long)atomic_load(&js->config->workers);
    pthread_mutex_unlock(&js->lock);
    return over;
}

void jobs_helped(struct jobs *js, const struct job *job, double seconds)
{
    pthread_mutex_lock(&js->lock);
    assert(js->helping > 0);
    js->helping--;
    if (!js->shared)
        quota_ran(job->account, seconds, sga_now());
    pthread_mutex_unlock(&js->lock);
}

void jobs_worker_unable(struct jobs *js, bool unable)
{
    pthread_mutex_lock(&js->lock);
    js->unable += unable ? 1 : -1;
    assert(js->unable >= 0);                 /* each worker tells of itself in turns */
    pthread_mutex_unlock(&js->lock);
}

static void poke(int fd)
{
    static const uint64_t one = 1;
    ssize_t ignored = write(fd, &one, sizeof one);
    (void)ignored;
}

enum cancel jobs_cancel(struct jobs *js, const char *id, const struct account *by, struct job **out)
{
    enum cancel outcome = CANCEL_ASKED;
    if (js->shared)
        return shared_cancel(js, id, by, out);
    pthread_mutex_lock(&js->lock);
    struct job *job = *jobs_place(js, id);
    if (!job) {
        outcome = CANCEL_UNKNOWN;
    } else if (by && !jobs_interested(job, by)) {
        outcome = CANCEL_NOT_YOURS;
    } else if (by && job->interests->next && !job->ending) {
        jobs_withdraw(js, job, by);
        outcome = CANCEL_WITHDRAWN;
        job_ref(job);
        *out = job;
    } else {
        job_ref(job);
        *out = job;
        if (job->queued) {
            jobs_dequeue(js, job);
            outcome = CANCEL_ENDED_NOW;
        } else if (job->ending || job->finished) {
            outcome = CANCEL_TOO_LATE;
        } else {
            job->cancel = true;
            if (job->wake_fd >= 0)
                poke(job->wake_fd);
        }
    }
    pthread_mutex_unlock(&js->lock);
    if (outcome == CANCEL_ENDED_NOW)
        end_cancelled(js, job);
    return outcome;
}

void jobs_drain(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    js->draining = true;
    pthread_cond_broadcast(&js->work);
    pthread_mutex_unlock(&js->lock);
}

void jobs_leave(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    js->leaving = true;
    pthread_cond_broadcast(&js->work);
    pthread_mutex_unlock(&js->lock);
}

bool jobs_resting(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    bool resting = js->draining || js->leaving;
    pthread_mutex_unlock(&js->lock);
    return resting;
}

bool jobs_draining(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    bool draining = js->draining;
    pthread_mutex_unlock(&js->lock);
    return draining;
}

void jobs_stop_running(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    js->stopping = true;
    for (int i = 0; i < JOBS_BUCKETS; i++)
        for (struct job *job = js->bucket[i]; job; job = job->chain)
            if (job->wake_fd >= 0)
                poke(job->wake_fd);
    pthread_mutex_unlock(&js->lock);
}

bool jobs_stopping(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    bool stopping = js->stopping;
    pthread_mutex_unlock(&js->lock);
    return stopping;
}
