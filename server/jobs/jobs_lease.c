/* Our runs of jobs that daemons share, held by leases: claimed, renewed, given back, lost; see jobs_shared.h. */
#include "config.h"
#include "jobs_shared.h"
#include "budget.h"
#include "clock.h"
#include "log.h"
#include "metrics.h"
#include "no_memory.h"
#include "run.h"
#include "store.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

void shared_poke(const struct job *job)
{
    static const uint64_t one = 1;
    ssize_t ignored = job->wake_fd >= 0 ? write(job->wake_fd, &one, sizeof one) : 0;
    (void)ignored;
}

static struct store_claimant claimant(struct jobs *js)
{
    return (struct store_claimant){ .daemon = js->name, .version = sga_version(), .lease = (double)js->config->lease, .workers = js->config->workers,
                                    .share = js->config->token_workers };
}

/* The claimed job as ours, with a reference for its worker. NULL: an older run of it has not come to its end here. */
static struct job *adopt(struct jobs *js, const struct job_row *row, char *request, size_t length, int wake_fd)
{
    static const struct quota none;
    struct account *account = jobs_account_of(js, row->owner, &none);
    struct job *job = jobs_watch(js, row);
    if (!account || !job)
        no_memory("a job that was claimed");        /* after its lease another daemon runs it */
    pthread_mutex_lock(&js->lock);
    if (job->ours || job->finished || job->gone) {
        job->lost = job->ours;
        shared_poke(job);
        pthread_mutex_unlock(&js->lock);
        job_unref(job);
        return NULL;
    }
    if (job->order) {                    /* its text is still with the store: ours is a copy of it */
        free(request);
    } else {
        free(job->request);
        job->request = request;
        job->request_length = length;
    }
    assert(!job->queued && !job->ending && job->wake_fd < 0);
    job->stored = 1;                     /* whatever becomes of its order: see submitted() */
    job->ours = true;
    job->lost = job->cancel = job->killed = false;
    job->account = account;
    account->running++;
    account->alive++;
    account->reserved += (double)row->seconds;
    js->running++;
    job->row.status = JOB_RUNNING;
    job->row.started = row->started;
    job->row.created = row->created;
    job->row.attempts = row->attempts;
    job->row.epoch = row->epoch;
    job->row.seconds = row->seconds;
    snprintf(job->row.owner, sizeof job->row.owner, "%s", row->owner);
    job->began = sga_now();
    job->wake_fd = wake_fd;
    job->progress = (struct job_progress){ .stage = JOB_STAGE_CLAIMED };
    jobs_stage(job, STAGE_RUNNING);
    job->event++;
    jobs_notify(js, job);
    pthread_mutex_unlock(&js->lock);
    return job;
}

/* Under the lock, for at most so many seconds. */
static void wait_for_work(struct jobs *js, double seconds)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    int64_t ns = until.tv_nsec + (int64_t)(seconds * 1e9);
    until.tv_sec += ns / 1000000000;
    until.tv_nsec = ns % 1000000000;
    pthread_cond_timedwait(&js->work, &js->lock, &until);
}

struct job *shared_claim(struct jobs *js, int wake_fd)
{
    struct job *job = NULL;
    pthread_mutex_lock(&js->lock);
    while (!js->draining && !job) {
        unsigned long known = js->hints;
        bool may = js->ending_bytes <= (unsigned long)atomic_load(&js->config->unsaved_memory);
        struct job_row row = { .error = NULL };
        char *request = NULL;
        size_t length = 0;
        pthread_mutex_unlock(&js->lock);
        struct store_claimant me = claimant(js);
        bool found = may && store_claim(js->store, &me, &row, &request, &length) == STORE_FOUND;
        free(row.error);
        row.error = NULL;
        if (found && !(job = adopt(js, &row, request, length, wake_fd))) {
            free(request);
            row.error = js->cancelled_text;
            row.finished = clock_ms();
            store_release(js->store, &row, NULL, NULL, NULL);
        }
        pthread_mutex_lock(&js->lock);
        if (!job && !js->draining && (found || known == js->hints))
            wait_for_work(js, found ? SHARED_HINT : SHARED_LOOK * (0.75 + 0.5 * (double)(wake_fd % 16) / 16));
    }
    pthread_mutex_unlock(&js->lock);
    return job;
}

/* Under the lock: the job does not run here any more. */
void shared_let_go(struct jobs *js, struct job *job)
{
    assert(job->ours);
    if (job->row.status == JOB_RUNNING && !job->ending) {
        assert(js->running > 0 && job->account->running > 0);
        js->running--;
        job->account->running--;
        jobs_settle(job, 0);
    }
    job->ours = job->lost = job->cancel = false;
    job->wake_fd = -1;
    job->began = 0;
    job->event++;
}

void shared_release(struct jobs *js, struct job *job)
{
    struct job_row row = job->row;
    row.error = js->cancelled_text;
    row.finished = clock_ms();
    shared_let_go(js, job);
    job->row.status = JOB_QUEUED;
    job->row.started = 0;
    job->progress = (struct job_progress){ .stage = "queued" };
    store_release(js->store, &row, NULL, NULL, NULL);
    jobs_notify(js, job);
    store_hint(js->store);
}

bool jobs_lost(struct jobs *js, struct job *job)
{
    pthread_mutex_lock(&js->lock);
    bool lost = job->lost;
    if (lost) {
        log_event(LOG_L_WARN, "lease_lost", "job", job->row.id, NULL);
        shared_let_go(js, job);
        jobs_notify(js, job);
    }
    pthread_mutex_unlock(&js->lock);
    return lost;
}

bool shared_beat(struct jobs *js)
{
    size_t count;
    struct job **list = shared_collect(js, true, &count);
    struct store_beat *b = calloc(count + 1, sizeof *b);
    struct store_claimant me = claimant(js);
    for (size_t i = 0; b && i < count; i++) {
        pthread_mutex_lock(&js->lock);
        memcpy(b[i].id, list[i]->row.id, sizeof b[i].id);
        b[i].epoch = list[i]->row.epoch;
        b[i].progress = list[i]->progress;
        pthread_mutex_unlock(&js->lock);
    }
    bool told = b && store_beat(js->store, &me, b, (int)count);
    for (size_t i = 0; i < count; i++) {
        pthread_mutex_lock(&js->lock);
        struct job *job = list[i];
        if (told && job->ours && !job->ending && job->row.epoch == b[i].epoch && b[i].answer != BEAT_HELD) {
            job->lost |= b[i].answer == BEAT_LOST;
            job->cancel |= b[i].answer == BEAT_CANCEL;
            shared_poke(job);
        }
        pthread_mutex_unlock(&js->lock);
        job_unref(job);
    }
    free(b);
    free(list);
    return told;
}

void shared_reap(struct jobs *js)
{
    struct store_reaping r = { .tries = JOBS_TRIES, .died = js->died_text, .cancelled = js->cancelled_text, .now = clock_ms() };
    if (!store_reap(js->store, &r) || !r.count)
        return;
    char count[32];
    snprintf(count, sizeof count, "%ld", r.count);
    log_event(LOG_L_WARN, "jobs_reaped", "#count", count, NULL);
    store_hint(js->store);
}
