/* The one way to end: the end is made, goes to the disk, and then is everybody's. */
#include "jobs_parts.h"
#include "budget.h"
#include "clock.h"
#include "log.h"
#include "memory_cache.h"
#include "metrics.h"
#include "no_memory.h"
#include "problem.h"
#include "store.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

#include "error.h"

enum { LONGEST_PAUSE = 8 };       /* looks, of a second each, between two trials to write an end: a large one may cost as much each time */

static size_t ending_size(const struct job *job)
{
    return sizeof *job + job->ending->len + job->request_length;
}

/* Under the lock: everybody may know of the end. */
static void publish(struct jobs *js, struct job *job)
{
    assert(!job->finished && js->ending > 0 && js->ending_bytes >= ending_size(job));
    js->ending--;
    js->ending_bytes -= ending_size(job);
    job->row.status = job->end.status;      /* one by one: others read the id without the lock */
    job->row.finished = job->end.finished;
    job->row.error = job->end.error;
    job->end.error = NULL;
    job->finished = job->ending;
    job->ending = NULL;
    job->event++;
    if (job->stored == 1 && (!js->shared || job->row.status == JOB_DONE))    /* else another daemon may run it once more */
        memory_cache_put(js->memory_cache, job->finished);
    jobs_notify(js, job);
    pthread_cond_broadcast(&js->work);       /* workers that waited for the disk */
}

/* Under the lock: another daemon has the job, and its end is the one that counts. */
static void fenced(struct jobs *js, struct job *job)
{
    assert(job->ours && js->ending > 0 && js->ending_bytes >= ending_size(job));
    js->ending--;
    js->ending_bytes -= ending_size(job);
    shared_let_go(js, job);
    finished_unref(job->ending);
    job->ending = NULL;
    free(job->end.error);
    job->end.error = NULL;
    pthread_cond_broadcast(&js->work);
    jobs_notify(js, job);
}

/* The end is on disk: readers of the store know the job from now on. It stays in the table, where
 * it is found, until the disk takes it; one whose row was never on disk has nothing to keep. */
static void end_stored(void *ctx, enum store_kept how)
{
    struct job *job = ctx;
    struct jobs *js = job->table;
    if (how == STORE_FENCED)         /* another run's row stands */
        log_event(LOG_L_WARN, "end_fenced", "job", job->row.id, NULL);
    pthread_mutex_lock(&js->lock);
    bool over = how != STORE_LOST || job->stored != 1;
    assert(job->ending && !job->unsaved && *jobs_place(js, job->row.id) == job);     /* found until now by whoever asks */
    if (over && js->shared && how == STORE_FENCED) {
        fenced(js, job);
        over = false;
    } else if (over) {
        publish(js, job);
        *jobs_place(js, job->row.id) = job->chain;
    } else {
        job->unsaved = true;
        job->pause = js->shared || !job->pause ? 1 : job->pause < LONGEST_PAUSE ? 2 * job->pause : LONGEST_PAUSE;
        job->waits = job->pause;
        js->unsaved++;
    }
    pthread_mutex_unlock(&js->lock);
    if (over)
        job_unref(job);
    if (js->shared)
        store_hint(js->store);
    job_unref(job);
}

/* Under the lock: the end goes to the disk, now or as soon as there is memory for the order. */
static void save_end(struct jobs *js, struct job *job)
{
    job_ref(job);
    if (store_end(js->store, &job->end, job->ending->result, end_stored, job))
        return;
    atomic_fetch_sub(&job->refs, 1);         /* never the last: the table has one */
    job->unsaved = true;
    js->unsaved++;
}

void jobs_save_again(struct jobs *js)
{
    for (int i = 0; i < JOBS_BUCKETS && js->unsaved; i++)
        for (struct job *job = js->bucket[i]; job; job = job->chain) {
            if (!job->unsaved || (job->waits > 1 && job->waits--))
                continue;
            job->unsaved = false;
            js->unsaved--;
            save_end(js, job);
        }
}

/* result: of a job that is done, taken over; text: of others. */
static struct finished *make_text(struct job_row *row, char **result, size_t length, struct slice text)
{
    struct finished *f = row->status == JOB_DONE ? finished_take(row, result, length) : finished_make(row, text);
    if (f)
        return f;
    struct sga_error err = { .code = SGA_E_LIMIT_MEMORY, .stage = "result" };
    row->status = JOB_FAILED;
    free(row->error);
    row->error = problem_text(&err);
    f = finished_make(row, (struct slice){ NULL, 0 });
    if (!f)
        no_memory("the end of a job");         /* not even a few hundred bytes: the queue on disk is safe */
    return f;
}

static void log_end(const struct job *job, const struct job_row *row, const struct sga_error *err, double ran)
{
    char seconds[32];
    snprintf(seconds, sizeof seconds, "%.3f", ran);
    log_event(LOG_L_INFO, "job_ended", "job", row->id, "outcome", job_status_text(row->status), "#seconds", seconds,
              "code", err ? sga_code_text(err->code) : NULL, "token", *job->account->name ? job->account->name : NULL,
              "request_id", *job->request_id ? job->request_id : NULL,
              "traceparent", *job->traceparent ? job->traceparent : NULL, NULL);
}

void jobs_end(struct jobs *js, struct job *job, enum job_status status, const struct sga_error *err, char **result, size_t length)
{
    struct job_row row = job->row;
    assert(job_ended(status) && (status == JOB_DONE) == !err);
    row.status = status;
    row.finished = clock_after(row.started ? row.started : row.created);
    double ran = job->began ? sga_now() - job->began : 0;
    row.error = err ? problem_text(err) : NULL;
    struct slice request = { job->request, job->request ? job->request_length : 0 };      /* a job that failed keeps it */
    struct finished *f = make_text(&row, result, length, request);
    log_end(job, &row, err, ran);
    metrics_job(js->metrics, row.status, ran);
    pthread_mutex_lock(&js->lock);
    assert(!job->queued && !job->ending && !job->finished && (!js->shared || job->ours));       /* an end is made once */
    if (job->row.status == JOB_RUNNING)
        js->running--, job->account->running--;
    pthread_cond_broadcast(&js->work);       /* its account may have another worker */
    jobs_settle(job, ran);
    job->end = row;
    job->ending = f;
    job->wake_fd = -1;
    snprintf(job->progress.stage, sizeof job->progress.stage, "storing");
    job->progress.fraction = 1;
    job->progress.moves = false;
    job->event++;
    js->ending++;
    js->ending_bytes += ending_size(job);
    jobs_notify(js, job);
    save_end(js, job);
    pthread_mutex_unlock(&js->lock);
}

void jobs_done(struct jobs *js, struct job *job, char **result, size_t length)
{
    jobs_end(js, job, JOB_DONE, NULL, result, length);
}

void jobs_failed(struct jobs *js, struct job *job, const struct sga_error *err)
{
    jobs_end(js, job, err->code == SGA_E_CANCELLED ? JOB_CANCELLED : JOB_FAILED, err, NULL, 0);
}
