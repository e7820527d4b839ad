/* Running jobs: claiming, progress, cancelling, and the one way to end. */
#include "jobs_parts.h"
#include "clock.h"
#include "log.h"
#include "problem.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct job *jobs_claim(struct jobs *js, int wake_fd)
{
    pthread_mutex_lock(&js->lock);
    while (!js->turn && !js->draining)
        pthread_cond_wait(&js->work, &js->lock);
    struct job *job = js->draining ? NULL : jobs_next(js);
    if (job) {
        job_ref(job);
        job->row.status = JOB_RUNNING;
        job->row.started = clock_ms();
        snprintf(job->progress.stage, sizeof job->progress.stage, "running");
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

bool jobs_cancelled(struct jobs *js, struct job *job)
{
    pthread_mutex_lock(&js->lock);
    bool cancel = job->cancel;
    pthread_mutex_unlock(&js->lock);
    return cancel;
}

void jobs_progress(struct jobs *js, struct job *job, const char *stage, double fraction)
{
    pthread_mutex_lock(&js->lock);
    snprintf(job->progress.stage, sizeof job->progress.stage, "%s", stage);
    jobs_stage(job, metrics_stage_of(stage));
    job->progress.fraction = fraction >= 0 && fraction <= 1 ? fraction : 0;
    job->event++;
    jobs_notify(js, job);
    pthread_mutex_unlock(&js->lock);
}

/* The end is on disk: readers of the store know the job from now on. */
static void end_stored(void *ctx, bool ok)
{
    struct job *job = ctx;
    struct jobs *js = job->table;
    pthread_mutex_lock(&js->lock);
    struct job **at = jobs_place(js, job->row.id);
    bool mine = *at == job && ok;
    /* It stays in the table, where it is found, until the disk takes it. One that was
     * replaced by a new run of the same request need not be written any more, nor one
     * that was never on disk. */
    if (*at == job && !ok && job->stored == 1) {
        job->unsaved = true;
        js->unsaved++;
    } else if (*at == job) {
        mine = true;
    }
    if (mine)
        *at = job->chain;
    pthread_mutex_unlock(&js->lock);
    if (mine)
        job_unref(job);
    job_unref(job);
}

void jobs_save_again(struct jobs *js)
{
    for (int i = 0; i < JOBS_BUCKETS && js->unsaved; i++)
        for (struct job *job = js->bucket[i]; job; job = job->chain) {
            if (!job->unsaved)
                continue;
            job->unsaved = false;
            js->unsaved--;
            job_ref(job);
            if (!store_end(js->store, &job->row, job->finished->result, end_stored, job))
                job_unref(job);
        }
}

static struct finished *make_text(struct job_row *row, struct slice text)
{
    struct finished *f = finished_make(row, text);
    if (f)
        return f;
    struct sga_error err = { .code = SGA_E_LIMIT_MEMORY, .stage = "result" };
    row->status = JOB_FAILED;
    free(row->error);
    row->error = problem_text(&err);
    f = finished_make(row, (struct slice){ NULL, 0 });
    if (!f)
        abort();         /* not even a few hundred bytes: the queue on disk is safe */
    return f;
}

static void log_end(const struct job *job, const struct job_row *row, const struct sga_error *err)
{
    char seconds[32];
    snprintf(seconds, sizeof seconds, "%.3f", 1e-3 * (double)(row->started ? row->finished - row->started : 0));
    log_event(LOG_L_INFO, "job_ended", "job", row->id, "status", job_status_text(row->status), "seconds", seconds,
              "code", err ? sga_code_text(err->code) : NULL, "token", *job->account->name ? job->account->name : NULL,
              "request_id", *job->request_id ? job->request_id : NULL,
              "traceparent", *job->traceparent ? job->traceparent : NULL, NULL);
}

void jobs_end(struct jobs *js, struct job *job, enum job_status status, const struct sga_error *err, const char *result, size_t length)
{
    struct job_row row = job->row;
    row.status = status;
    row.finished = clock_ms();
    row.error = err ? problem_text(err) : NULL;
    struct slice text = { result, length };
    if (status != JOB_DONE)           /* a job that failed keeps its request */
        text = (struct slice){ job->request, job->request ? job->request_length : 0 };
    struct finished *f = make_text(&row, text);
    log_end(job, &row, err);
    metrics_job(js->metrics, row.status, 1e-3 * (double)(row.started ? row.finished - row.started : 0));
    job_ref(job);
    pthread_mutex_lock(&js->lock);
    if (job->row.status == JOB_RUNNING)
        js->running--;
    jobs_settle(job, 1e-3 * (double)(row.started ? row.finished - row.started : 0));
    job->row.status = row.status;      /* one by one: others read the id without the lock */
    job->row.finished = row.finished;
    job->row.error = row.error;
    job->finished = f;
    job->wake_fd = -1;
    job->event++;
    /* Under the lock: a new run of the same id must come later in the store's order, and
     * must not have its text replaced by this one. */
    memory_cache_put(js->memory_cache, f);
    bool given = store_end(js->store, &job->row, f->result, end_stored, job);
    jobs_notify(js, job);
    pthread_mutex_unlock(&js->lock);
    if (!given)
        job_unref(job);
}

void jobs_done(struct jobs *js, struct job *job, const char *result, size_t length)
{
    jobs_end(js, job, JOB_DONE, NULL, result, length);
}

void jobs_failed(struct jobs *js, struct job *job, const struct sga_error *err)
{
    jobs_end(js, job, err->code == SGA_E_CANCELLED ? JOB_CANCELLED : JOB_FAILED, err, NULL, 0);
}

void jobs_requeue(struct jobs *js, struct job *job)
{
    pthread_mutex_lock(&js->lock);
    job->row.status = JOB_QUEUED;
    job->row.started = 0;
    job->wake_fd = -1;
    job->progress = (struct job_progress){ .stage = "queued" };
    jobs_stage(job, STAGE_NONE);
    job->event++;
    js->running--;
    store_requeue(js->store, &job->row);
    jobs_notify(js, job);
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
    pthread_mutex_lock(&js->lock);
    struct job *job = *jobs_place(js, id);
    if (!job) {
        outcome = CANCEL_UNKNOWN;
    } else if (by && strcmp(job->row.owner, by->name) != 0) {
        outcome = CANCEL_NOT_YOURS;
    } else {
        job_ref(job);
        *out = job;
        if (job->queued) {
            jobs_dequeue(js, job);
            outcome = CANCEL_ENDED_NOW;
        } else if (job->finished) {
            outcome = CANCEL_TOO_LATE;
        } else {
            job->cancel = true;
            if (job->wake_fd >= 0)
                poke(job->wake_fd);
        }
    }
    pthread_mutex_unlock(&js->lock);
    if (outcome == CANCEL_ENDED_NOW) {
        struct sga_error err = { .code = SGA_E_CANCELLED, .stage = "queue" };
        snprintf(err.detail, sizeof err.detail, "The job was cancelled before it ran.");
        jobs_end(js, job, JOB_CANCELLED, &err, NULL, 0);
    }
    return outcome;
}

void jobs_drain(struct jobs *js)
{
    pthread_mutex_lock(&js->lock);
    js->draining = true;
    pthread_cond_broadcast(&js->work);
    pthread_mutex_unlock(&js->lock);
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
