/* Looking up jobs. A job is in memory until its end is on disk, so the order alive, recent,
 * stored never misses one. */
#include "lookup.h"
#include "clock.h"
#include "config.h"
#include "error.h"
#include "finished.h"
#include "job.h"
#include "jobs.h"
#include "memory_cache.h"
#include "service.h"
#include "store.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static enum lookup from_store(struct service *sv, const char *id, struct job **job, struct finished **finished)
{
    struct job_row row;
    enum store_answer a = store_job(sv->store, id, &row);
    if (a != STORE_FOUND)
        return a == STORE_NONE ? LOOKUP_NONE : LOOKUP_BROKEN;
    enum lookup outcome = LOOKUP_STORED;
    /* Asked before the text is read: each HTTP thread may go past the limit by one result. What
     * is kept among the recent replies is counted too, and has its own share. */
    bool full = atomic_load(&sv->reply_bytes) >= atomic_load(&sv->config->reply_memory) + atomic_load(&sv->config->cache_memory);
    if (row.status == JOB_DONE && full)
        outcome = LOOKUP_BUSY;
    else if (!job_ended(row.status) && store_shared(sv->store))
        outcome = (*job = jobs_watch(sv->jobs, &row)) ? LOOKUP_LIVE : LOOKUP_BROKEN;
    else if (!job_ended(row.status))
        outcome = LOOKUP_BROKEN;        /* its end could not be written */
    else if ((a = store_finished(sv->store, id, &row, finished)) != STORE_FOUND)
        outcome = a == STORE_NONE ? LOOKUP_GONE : LOOKUP_BROKEN;
    else if (row.status == JOB_DONE) {
        finished_book(*finished, &sv->reply_bytes);
        store_touch(sv->store, id, clock_ms());
        memory_cache_put(sv->memory_cache, *finished);      /* other ends may be replaced by a new run */
    }
    free(row.error);
    return outcome;
}

/* A job that is done and whose result was dropped or damaged: its request is run again, on the
 * account of who asks. It stays its owner's. */
static enum lookup revive(struct service *sv, struct account *account, const char *id, struct job **job, struct finished **finished)
{
    struct submission s = { .id = id, .account = account, .request_id = "", .traceparent = "", .again = true };
    enum lookup outcome = LOOKUP_GONE;
    struct job_row row = { .error = NULL };
    if (store_job(sv->store, id, &row) != STORE_FOUND)
        return LOOKUP_BROKEN;
    free(row.error);
    s.owner = row.owner;
    if (store_request(sv->store, id, &s.request, &s.length) != STORE_FOUND)
        return LOOKUP_BROKEN;
    switch (jobs_submit(sv->jobs, &s)) {
    case SUBMIT_NEW:
    case SUBMIT_JOINED:
        outcome = LOOKUP_LIVE;
        break;
    case SUBMIT_DONE:
        outcome = LOOKUP_RECENT;
        break;
    case SUBMIT_FULL:
    case SUBMIT_QUOTA:
        outcome = LOOKUP_FULL;
        break;
    default:
        break;
    }
    free(s.request);
    if (s.job)
        jobs_load_interests(sv->jobs, s.job);
    *job = s.job;
    *finished = s.finished;
    return outcome;
}

enum lookup lookup_or_run(struct service *sv, struct account *account, const char *id, struct job **job, struct finished **finished)
{
    enum lookup found = lookup_job(sv, id, job, finished);
    return found == LOOKUP_GONE ? revive(sv, account, id, job, finished) : found;
}

enum lookup lookup_job(struct service *sv, const char *id, struct job **job, struct finished **finished)
{
    if (!digest_is_id(id, strlen(id)))
        return LOOKUP_NONE;
    struct job *live = jobs_find(sv->jobs, id);
    if (live) {
        struct job_look look;
        if (store_shared(sv->store))
            jobs_refresh(sv->jobs, live);
        jobs_look(sv->jobs, live, &look);
        assert(!look.gone || !look.finished);
        if (look.gone) {
            job_unref(live);
            return LOOKUP_NONE;
        }
        if (!look.finished) {
            *job = live;
            return LOOKUP_LIVE;
        }
        job_unref(live);
        *finished = look.finished;
        return LOOKUP_RECENT;
    }
    if ((*finished = memory_cache_by_id(sv->memory_cache, id)))
        return LOOKUP_RECENT;
    return from_store(sv, id, job, finished);
}

struct sga_error lookup_error(enum lookup outcome)
{
    struct sga_error err = { .code = outcome == LOOKUP_BROKEN ? SGA_E_STORE : outcome == LOOKUP_BUSY ? SGA_E_BUSY
                                     : outcome == LOOKUP_FULL ? SGA_E_QUEUE_FULL : SGA_E_NOT_FOUND };
    snprintf(err.detail, sizeof err.detail, "%s",
             outcome == LOOKUP_BROKEN ? "The job cannot be read from the store."
             : outcome == LOOKUP_BUSY ? "The results that are being sent take as much memory as they may. Try again soon."
             : outcome == LOOKUP_FULL ? "The result of this job is no longer stored, and the queue or a quota is full, so that it cannot be "
                                        "computed again now. Try again later."
             : outcome == LOOKUP_GONE ? "The result of this job is no longer stored. Post its request again, with a token that has the scope submit."
             : "There is no job with this id.");
    return err;
}
