/* Jobs that run on other daemons, as far as somebody here waits for them: see jobs_shared.h. */
#include "finished.h"
#include "jobs_shared.h"
#include "memory_cache.h"
#include "store.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void shared_leave_table(struct jobs *js, struct job *job)
{
    struct job **at = jobs_place(js, job->row.id);
    if (*at != job)
        return;
    assert(!job->ours);                  /* ours leave by their end */
    *at = job->chain;
    job->chain = NULL;
    job_unref(job);
}

struct job *jobs_watch(struct jobs *js, const struct job_row *row)
{
    static const struct quota none;
    struct account *account = jobs_account_of(js, row->owner, &none);
    struct job *fresh = account ? jobs_make(js, row->id, account) : NULL;
    if (!fresh)
        return NULL;
    fresh->row = *row;
    fresh->row.error = NULL;
    fresh->stored = 1;
    snprintf(fresh->progress.stage, sizeof fresh->progress.stage, "%s", job_status_text(row->status));
    pthread_mutex_lock(&js->lock);
    struct job **at = jobs_place(js, row->id), *job = *at ? *at : fresh;
    if (job == fresh)
        *at = fresh;
    job_ref(job);
    pthread_mutex_unlock(&js->lock);
    if (job != fresh)
        job_unref(fresh);
    return job;
}

/* The end of a job as another daemon wrote it. NULL: it cannot be read now. */
static struct finished *read_end(struct jobs *js, const char *id, struct job_row *row)
{
    struct finished *f = NULL;
    if (store_job(js->store, id, row) != STORE_FOUND)
        return NULL;
    enum store_answer a = job_ended(row->status) ? store_finished(js->store, id, row, &f) : STORE_BROKEN;
    return a == STORE_NONE ? finished_make(row, (struct slice){ NULL, 0 }) : f;
}

static bool same_state(const struct job *job, const struct job_row *row, const struct job_progress *p)
{
    return job->row.status == row->status && job->row.epoch == row->epoch && job->row.attempts == row->attempts && job->row.started == row->started
        && job->progress.fraction == p->fraction && strcmp(job->progress.stage, p->stage) == 0
        && job->progress.moves == p->moves && (!p->moves || job->progress.t == p->t);
}

void jobs_refresh(struct jobs *js, struct job *job)
{
    struct job_row row = { .error = NULL }, end = { .error = NULL };
    struct job_progress progress;
    pthread_mutex_lock(&js->lock);
    bool wanted = !job->ours && job->stored == 1 && !job->finished && !job->gone;
    pthread_mutex_unlock(&js->lock);
    enum store_answer a = wanted ? store_look_at(js->store, job->row.id, &row, &progress) : STORE_BROKEN;
    if (a == STORE_BROKEN)
        return;
    struct finished *f = a == STORE_FOUND && job_ended(row.status) ? read_end(js, job->row.id, &end) : NULL;
    if (a == STORE_FOUND && job_ended(row.status) && !f) {
        free(end.error);
        return;
    }
    pthread_mutex_lock(&js->lock);
    if (job->ours || job->finished || job->gone) {
        finished_unref(f);
        free(end.error);
    } else if (a == STORE_NONE) {        /* removed meanwhile, by an administrator or by age */
        job->gone = true;
        job->event++;
        shared_leave_table(js, job);
    } else if (f) {
        job->row.status = end.status;
        job->row.started = end.started;
        job->row.finished = end.finished;
        job->row.attempts = end.attempts;
        job->row.error = end.error;
        job->finished = f;
        job->event++;
        if (end.status == JOB_DONE && f->result.at)
            memory_cache_put(js->memory_cache, f);
        shared_leave_table(js, job);
    } else if (!same_state(job, &row, &progress)) {
        job->row.status = row.status;
        job->row.started = row.started;
        job->row.attempts = row.attempts;
        job->row.epoch = row.epoch;
        job->progress = progress;
        job->event++;
    }
    jobs_notify(js, job);
    pthread_mutex_unlock(&js->lock);
}

struct job **shared_collect(struct jobs *js, bool ours, size_t *count)
{
    size_t room = 0;
    struct job **list = NULL;
    *count = 0;
    pthread_mutex_lock(&js->lock);
    for (int i = 0; i < JOBS_BUCKETS; i++)
        for (struct job *job = js->bucket[i], *next; job; job = next) {
            next = job->chain;
            if (job->ours != ours || (ours && job->row.status != JOB_RUNNING))
                continue;
            if (!ours && job->stored == 1 && atomic_load(&job->refs) == 1) {
                shared_leave_table(js, job);
                continue;
            }
            if (*count == room) {
                struct job **more = realloc(list, (room = room ? 2 * room : 64) * sizeof(struct job *));
                if (!more)
                    break;
                list = more;
            }
            job_ref(job);
            list[(*count)++] = job;
        }
    pthread_mutex_unlock(&js->lock);
    return list;
}

void shared_follow(struct jobs *js)
{
    size_t count;
    struct job **list = shared_collect(js, false, &count);
    for (size_t i = 0; i < count; i++) {
        jobs_refresh(js, list[i]);
        job_unref(list[i]);
    }
    free(list);
}
