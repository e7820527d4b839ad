/* What is asked of a store that several daemons share, which decides: to take a job, to cancel one; see jobs_shared.h. */
#include "jobs_shared.h"
#include "clock.h"
#include "config.h"
#include "metrics.h"
#include "store.h"

#include <assert.h>
#include <semaphore.h>
#include <stdio.h>
#include <stdlib.h>

/* -- Submitting -- */

static void submitted(void *ctx, enum store_kept how)
{
    struct job *job = ctx;
    struct jobs *js = job->table;
    pthread_mutex_lock(&js->lock);
    const struct store_submission *s = job->order;
    bool in = how == STORE_KEPT && s->outcome != STORE_FULL && s->outcome != STORE_QUOTA, claimed = job->stored == 1;
    if (claimed && !in) {                /* the answer was lost, or the row is another daemon's: it is there, and was claimed here meanwhile */
        if (s->join)
            store_note(js->store, job->row.id, s->row.owner);
        in = true;
    }
    assert(claimed || !job->stored);
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
        shared_leave_table(js, job);
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
    struct job **at = jobs_place(js, s->id);
    assert(!*at);                    /* one job for each id */
    *at = job;
    job_ref(job);                    /* the store's */
    job_ref(job);                    /* the caller's */
    if (!store_submit(js->store, order, submitted, job)) {
        job_unref(job);
        job_unref(job);
        shared_leave_table(js, job);
        return SUBMIT_NO_MEMORY;
    }
    s->job = job;
    return SUBMIT_NEW;
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
    *out = store_job(js->store, id, &row) == STORE_FOUND ? jobs_watch(js, &row) : NULL;
    free(row.error);
    if (!*out)
        return CANCEL_BROKEN;
    pthread_mutex_lock(&js->lock);
    if (c.outcome == STORE_ASKED && (*out)->ours) {
        (*out)->cancel = true;
        shared_poke(*out);
    }
    pthread_mutex_unlock(&js->lock);
    jobs_refresh(js, *out);
    return outcomes[c.outcome];
}
