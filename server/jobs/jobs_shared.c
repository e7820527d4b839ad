/* Jobs of a store that several daemons share: the store decides, this table only follows.
 *
 * A job in the table either runs here (ours), or somebody here waits for it: then one thread looks
 * at its row in the store, when a hint says that something changed and once a second in any case.
 * The same thread renews the leases of our runs, and takes over what other daemons left behind. */
#include "jobs_parts.h"
#include "budget.h"
#include "clock.h"
#include "log.h"
#include "no_memory.h"
#include "problem.h"
#include "run.h"

#include <errno.h>
#include <semaphore.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

static const double LOOK_SECONDS = 1, HINT_SECONDS = 0.1, BEAT_LEAST = 0.3;

/* -- Submitting -- */

static void leave_table(struct jobs *js, struct job *job)
{
    struct job **at = jobs_place(js, job->row.id);
    if (*at != job)
        return;
    *at = job->chain;
    job->chain = NULL;
    job_unref(job);
}

static void submitted(void *ctx, enum store_kept how)
{
    struct job *job = ctx;
    struct jobs *js = job->table;
    pthread_mutex_lock(&js->lock);
    const struct store_submission *s = job->order;
    bool in = how == STORE_KEPT && s->outcome != STORE_FULL && s->outcome != STORE_QUOTA;
    job->stored = in ? 1 : -1;
    if (in) {
        metrics_add(js->metrics, s->outcome == STORE_NEW ? METRIC_JOBS_NEW : METRIC_JOBS_JOINED);
        job->account->accepted += s->outcome == STORE_NEW;
        js->hints++;
        pthread_cond_broadcast(&js->work);
    } else {
        job->refused = how == STORE_LOST ? SUBMIT_NEW : s->outcome == STORE_FULL ? SUBMIT_FULL : SUBMIT_QUOTA;
        job->account->refused += job->refused != SUBMIT_NEW;
        job->quota = s->quota;
        job->retry = s->retry;
        job->gone = true;
        leave_table(js, job);
    }
    if (!job->ours) {
        free(job->request);          /* of no use here any more */
        job->request = NULL;
        job->request_length = 0;
    }
    free(job->order);
    job->order = NULL;
    jobs_notify(js, job);
    pthread_mutex_unlock(&js->lock);
    store_hint(js->store);
    job_unref(job);
}

enum submit shared_submit(struct jobs *js, struct submission *s)
{
    const struct config *c = js->config;
    const struct quota *q = &s->account->quota;
    struct job *job = jobs_make(js, s->id, s->account);
    struct store_submission *order = job ? calloc(1, sizeof *order) : NULL;
    if (!order) {
        job_unref(job);
        return SUBMIT_NO_MEMORY;
    }
    job->row.created = clock_ms();
    if (s->owner)
        snprintf(job->row.owner, sizeof job->row.owner, "%s", s->owner);
    snprintf(job->request_id, sizeof job->request_id, "%s", s->request_id);
    snprintf(job->traceparent, sizeof job->traceparent, "%s", s->traceparent);
    job->row.seconds = (int64_t)jobs_seconds(c, s->request, s->length) + 1;
    *order = (struct store_submission){ .row = job->row, .request = { s->request, s->length }, .join = !s->owner, .again = s->again };
    bool limited = s->account != js->everyone;
    order->room = (struct store_room){ .queue = c->queue, .queue_bytes = c->queue_bytes, .share = limited ? c->queue * c->token_queue / 100 + 1 : 0,
                                       .jobs = q->jobs, .bytes = q->bytes, .seconds = q->seconds, .used = (int64_t)s->account->used };
    job->order = order;
    job->request = s->request;
    job->request_length = s->length;
    s->request = NULL;
    *jobs_place(js, s->id) = job;
    job_ref(job);                    /* the store's */
    job_ref(job);                    /* the caller's */
    if (!store_submit(js->store, order, submitted, job)) {
        job_unref(job);
        job_unref(job);
        leave_table(js, job);
        return SUBMIT_NO_MEMORY;
    }
    s->job = job;
    return SUBMIT_NEW;
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

/* -- Following -- */

/* The end of a job as another daemon wrote it. NULL: it cannot be read now. */
static struct finished *read_end(struct jobs *js, const char *id, struct job_row *row)
{
    char *text = NULL;
    size_t length = 0;
    if (store_job(js->store, id, row) != STORE_FOUND)
        return NULL;
    enum store_answer a = !job_ended(row->status) ? STORE_BROKEN : (row->status == JOB_DONE ? store_result : store_request)(js->store, id, &text, &length);
    struct finished *f = a == STORE_BROKEN ? NULL : finished_take(row, &text, length);
    free(text);
    return f;
}

static bool same_state(const struct job *job, const struct job_row *row, const struct job_progress *p)
{
    return job->row.status == row->status && job->row.epoch == row->epoch && job->row.attempts == row->attempts && job->row.started == row->started
        && job->progress.fraction == p->fraction && strcmp(job->progress.stage, p->stage) == 0;
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
        leave_table(js, job);
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
        leave_table(js, job);
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

/* References to all jobs of a kind; malloc'ed. Watched ones that nobody waits for leave the table. */
static struct job **collect(struct jobs *js, bool ours, size_t *count)
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
                leave_table(js, job);
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

static void follow(struct jobs *js)
{
    size_t count;
    struct job **list = collect(js, false, &count);
    for (size_t i = 0; i < count; i++) {
        jobs_refresh(js, list[i]);
        job_unref(list[i]);
    }
    free(list);
}

/* -- Running -- */

static void poke(const struct job *job)
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
        poke(job);
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
    job->progress = (struct job_progress){ .stage = "running" };
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
            wait_for_work(js, found ? HINT_SECONDS : LOOK_SECONDS * (0.75 + 0.5 * (double)(wake_fd % 16) / 16));
    }
    pthread_mutex_unlock(&js->lock);
    return job;
}

/* Under the lock: the job does not run here any more. */
void shared_let_go(struct jobs *js, struct job *job)
{
    if (job->row.status == JOB_RUNNING && !job->ending) {
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

static bool beat(struct jobs *js)
{
    size_t count;
    struct job **list = collect(js, true, &count);
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
            poke(job);
        }
        pthread_mutex_unlock(&js->lock);
        job_unref(job);
    }
    free(b);
    free(list);
    return told;
}

static void reap(struct jobs *js)
{
    struct store_reaping r = { .tries = JOBS_TRIES, .died = js->died_text, .cancelled = js->cancelled_text, .now = clock_ms() };
    if (!store_reap(js->store, &r) || !r.count)
        return;
    char count[32];
    snprintf(count, sizeof count, "%ld", r.count);
    log_event(LOG_L_WARN, "jobs_reaped", "#count", count, NULL);
    store_hint(js->store);
}

/* A database that was away let all leases run out: who can beat again does so before anybody reaps. */
static void *keep(void *arg)
{
    struct jobs *js = arg;
    double lease = (double)js->config->lease, beat_at = 0, reap_at = sga_now() + lease, looked = 0, took = 0, chore_at = 0, beaten = 0;
    bool due = false;
    while (!atomic_load(&js->keeper_stops)) {
        double before = sga_now();
        store_listen(js->store, before < looked + LOOK_SECONDS ? looked + LOOK_SECONDS - before : 0.01);
        bool hinted = sga_now() < looked + LOOK_SECONDS;
        double now = sga_now(), pause = looked + (took > HINT_SECONDS ? took : HINT_SECONDS) - now;
        if (pause > 0)
            usleep((unsigned)(1e6 * pause));
        pthread_mutex_lock(&js->lock);
        js->hints++;
        pthread_cond_broadcast(&js->work);
        pthread_mutex_unlock(&js->lock);
        now = sga_now();
        due |= hinted;                   /* a hint may be of a cancellation */
        if (now >= beat_at || (due && now >= beaten + BEAT_LEAST)) {
            due = false;
            beaten = now;
            if (beat(js))
                beat_at = now + lease / 3;
            else
                reap_at = now + 1.5 * lease;
        }
        looked = sga_now();
        follow(js);
        took = sga_now() - looked;
        if (sga_now() >= reap_at) {
            reap(js);
            reap_at = sga_now() + lease / 3;
        }
        pthread_mutex_lock(&js->lock);
        void (*chore)(void *) = sga_now() >= chore_at ? js->chore : NULL;
        void *of = js->chore_of;
        pthread_mutex_unlock(&js->lock);
        if (chore) {
            chore(of);
            chore_at = sga_now() + LOOK_SECONDS;
        }
    }
    return NULL;
}

static char *problem(enum sga_code code, const char *detail)
{
    struct sga_error err = { .code = code, .stage = "queue" };
    snprintf(err.detail, sizeof err.detail, "%s", detail);
    return problem_text(&err);
}

bool shared_start(struct jobs *js, char *why, size_t size)
{
    char host[64] = "", bits[16] = "";
    unsigned number = 0;
    gethostname(host, sizeof host - 1);
    if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number)
        number = (unsigned)clock_ms();
    snprintf(bits, sizeof bits, "%08x", number);
    snprintf(js->name, sizeof js->name, "%s-%ld-%s", host, (long)getpid(), bits);
    js->cancelled_text = problem(SGA_E_CANCELLED, "The job was cancelled before it ran.");
    js->died_text = problem(SGA_E_WORKER_DIED, "The daemons that ran this job ended or were cut off, several times; it is not tried again.");
    snprintf(why, size, js->cancelled_text && js->died_text ? "the database did not take a beat of this daemon" : "out of memory");
    return js->cancelled_text && js->died_text && beat(js) && (js->keeps = pthread_create(&js->keeper, NULL, keep, js) == 0);
}

void jobs_chore(struct jobs *js, void (*chore)(void *ctx), void *ctx)
{
    pthread_mutex_lock(&js->lock);
    js->chore_of = ctx;
    js->chore = chore;
    pthread_mutex_unlock(&js->lock);
}

void shared_stop(struct jobs *js)
{
    atomic_store(&js->keeper_stops, true);
    if (js->keeps)
        pthread_join(js->keeper, NULL);
    js->keeps = false;
}

/* -- Cancelling -- */

struct turn { sem_t over; enum store_kept how; };

static void over(void *ctx, enum store_kept how)
{
    struct turn *t = ctx;
    t->how = how;
    sem_post(&t->over);
}

enum cancel shared_cancel(struct jobs *js, const char *id, const struct account *by, struct job **out)
{
    static const enum cancel outcomes[] = { [STORE_UNKNOWN] = CANCEL_UNKNOWN, [STORE_NOT_YOURS] = CANCEL_NOT_YOURS, [STORE_WITHDRAWN] = CANCEL_WITHDRAWN,
                                            [STORE_CANCELLED] = CANCEL_ENDED_NOW, [STORE_ASKED] = CANCEL_ASKED, [STORE_ENDED] = CANCEL_TOO_LATE };
    struct store_cancel c = { .id = id, .owner = by ? by->name : NULL, .error = js->cancelled_text, .now = clock_ms() };
    struct turn t = { .how = STORE_LOST };
    struct job_row row = { .error = NULL };
    sem_init(&t.over, 0, 0);
    if (store_cancel(js->store, &c, over, &t))
        while (sem_wait(&t.over) != 0)
            continue;
    sem_destroy(&t.over);
    if (t.how != STORE_KEPT)
        return CANCEL_BROKEN;
    if (c.outcome == STORE_UNKNOWN || c.outcome == STORE_NOT_YOURS)
        return outcomes[c.outcome];
    store_hint(js->store);               /* whoever runs it hears of it by its next beat */
    if (store_job(js->store, id, &row) != STORE_FOUND || !(*out = jobs_watch(js, &row)))
        return CANCEL_BROKEN;
    free(row.error);
    pthread_mutex_lock(&js->lock);
    if (c.outcome == STORE_ASKED && (*out)->ours) {
        (*out)->cancel = true;
        poke(*out);
    }
    pthread_mutex_unlock(&js->lock);
    jobs_refresh(js, *out);
    return outcomes[c.outcome];
}
