/* POST /v1/jobs and POST /v1/solve: from bytes to a job, or to its finished answer.
 *
 * A body seen before is answered from memory without reading it. Otherwise a child process
 * checks it and makes the canonical text, whose digest is the job's id. A 202 waits for the
 * job's row on disk, the end of a job for that end: what was said stays true over a crash. */
#include "budget.h"
#include "check_threads.h"
#include "config.h"
#include "finished.h"
#include "handlers.h"
#include "jobs.h"
#include "lookup.h"
#include "memory_cache.h"
#include "memory_room.h"
#include "metrics.h"
#include "reply.h"
#include "run.h"
#include "service.h"
#include "store.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"

enum { SOLVE_SECONDS = 30, RETRY_SECONDS = 1, FULL_SECONDS = 5 };

static enum MHD_Result hit(struct exchange *e, struct finished *f, enum metrics_counter from)
{
    metrics_add(e->service->metrics, from);
    if (*e->account->name)
        jobs_note(e->service->jobs, f->id, e->account);
    reply_header(e, "Location", "/v1/jobs/%s", f->id);
    reply_tag(e, f->etag, f->len, "");
    return reply_finished(e, 200, f, true);
}

/* The end of a job, which the client waited for or was faster than its 202. Takes over the reference. */
static enum MHD_Result ended(struct exchange *e, struct finished *f)
{
    reply_header(e, "Location", "/v1/jobs/%s", f->id);
    reply_tag(e, f->etag, f->len, "");
    return reply_finished(e, e->wait_seconds > 0 ? 200 : 202, f, false);
}

/* The job could not be kept. Who waited for an answer gets it all the same, without a Location. */
static enum MHD_Result not_stored(struct exchange *e, struct finished *f)
{
    if (f && f->status == JOB_DONE && e->wait_seconds > 0)
        return reply_finished(e, 200, f, false);
    finished_unref(f);
    reply_header(e, "Retry-After", "%d", RETRY_SECONDS);
    return jobs_draining(e->service->jobs) ? reply_error(e, SGA_E_DRAINING, "The service is shutting down and could not keep the job.")
                                           : reply_error(e, SGA_E_STORE, "The job could not be written to the store.");
}

static enum MHD_Result refuse(struct exchange *e, enum submit why, const char *quota, long retry)
{
    const struct config *c = e->service->config;
    switch (why) {
    case SUBMIT_DRAINING:
        reply_header(e, "Retry-After", "%d", FULL_SECONDS);
        return reply_error(e, SGA_E_DRAINING, "The service is shutting down. Try again later.");
    case SUBMIT_QUOTA:
        reply_header(e, "Retry-After", "%ld", retry);
        return reply_error(e, SGA_E_QUOTA, "This token has used up its quota of %s.", quota);
    case SUBMIT_FULL:
        reply_header(e, "Retry-After", "%d", FULL_SECONDS);
        return reply_error(e, SGA_E_QUEUE_FULL, "The queue holds as much as it may: %ld jobs, or %ld bytes of requests.",
                           atomic_load(&c->queue), atomic_load(&c->queue_bytes));
    default:
        reply_header(e, "Retry-After", "%d", FULL_SECONDS);
        return reply_error(e, SGA_E_BUSY, "There is not enough memory for another job at this moment. Try again soon.");
    }
}

/* The job in its present state: its end, or 202 once its row is on disk. */
static enum MHD_Result answer(struct exchange *e)
{
    struct job_look look;
    if (e->wait_seconds > 0 && exchange_wait(e, WAIT_ENDED, e->wait_until))
        return MHD_YES;
    if (!e->stored_until)             /* once: a disk that stands still ends in a 503 */
        e->stored_until = sga_now() + (double)e->service->config->store_timeout;
    if (exchange_wait(e, WAIT_STORED, e->stored_until))
        return MHD_YES;
    jobs_look(e->service->jobs, e->job, &look);
    if (e->preferred)
        reply_header(e, "Preference-Applied", "wait=%ld", e->wait_seconds);
    if (look.stored != 1 && (look.refused == SUBMIT_FULL || look.refused == SUBMIT_QUOTA))
        return refuse(e, look.refused, look.quota, look.retry);
    if (look.stored != 1)
        return not_stored(e, look.finished);
    if (look.finished)
        return ended(e, look.finished);
    reply_header(e, "Location", "/v1/jobs/%s", look.row.id);
    reply_header(e, "Retry-After", "%d", RETRY_SECONDS);
    return reply_job(e, 202, &look);
}

/* Jobs that are each token's own have its name in theirs; so have the digests of bodies. */
static void name_job(struct exchange *e, char id[ID_LENGTH + 1], const struct sga_buf *canonical)
{
    char version[ACCOUNT_NAME + 160];
    bool own = config_isolated(e->service->config);
    snprintf(version, sizeof version, "%s%s%s", sga_version(), own ? " for " : "", own ? e->account->name : "");
    digest_id(id, version, canonical->data, canonical->len);
}

static void name_body(struct exchange *e)
{
    if (config_isolated(e->service->config))
        digest_kept(e->check.sum, e->account->name, e->body, e->length);
    else
        digest(e->check.sum, e->body, e->length);
}

/* A checked request: answered, refused, or a job in e->job. */
static enum MHD_Result submit(struct exchange *e, const unsigned char *sum, struct sga_buf *canonical)
{
    struct service *sv = e->service;
    char id[ID_LENGTH + 1];
    struct finished *f = NULL;
    size_t length = canonical->len;
    exchange_free_body(e);            /* who waits holds no memory for what is known already */
    name_job(e, id, canonical);
    memory_cache_alias(sv->memory_cache, sum, id);
    enum lookup found = lookup_job(sv, id, &e->job, &f);
    if (f && f->status == JOB_DONE)
        return hit(e, f, found == LOOKUP_STORED ? METRIC_CACHE_STORE : METRIC_CACHE_MEMORY);
    finished_unref(f);
    if (found == LOOKUP_BROKEN && !store_healthy(sv->store))
        return reply_error(e, SGA_E_STORE, "The store cannot be read.");
    if (found == LOOKUP_BUSY)
        return reply_lookup(e, found);
    job_unref(e->job);
    e->job = NULL;
    struct submission s = { .id = id, .again = found == LOOKUP_GONE, .request = sga_buf_take(canonical), .length = length, .account = e->account,
                            .request_id = e->request_id, .traceparent = e->traceparent };
    enum submit outcome = jobs_submit(sv->jobs, &s);
    free(s.request);
    if (outcome == SUBMIT_DONE)
        return hit(e, s.finished, METRIC_CACHE_MEMORY);
    if (outcome != SUBMIT_NEW && outcome != SUBMIT_JOINED)
        return refuse(e, outcome, s.quota, s.retry);
    e->job = s.job;
    metrics_add(sv->metrics, METRIC_CACHE_MISSES);
    return answer(e);
}

static enum MHD_Result busy(struct exchange *e, const char *why)
{
    reply_header(e, "Retry-After", "%d", FULL_SECONDS);
    return reply_error(e, SGA_E_BUSY, "%s Try again soon.", why);
}

/* The body was checked, by a child. */
static enum MHD_Result checked(struct exchange *e, long seconds)
{
    exchange_prefer(e, seconds);
    if (!e->check.ok) {
        if (e->check.err.code == SGA_E_DRAINING || e->check.err.code == SGA_E_BUSY)
            reply_header(e, "Retry-After", "%d", FULL_SECONDS);
        return reply_problem(e, &e->check.err);
    }
    struct sga_buf canonical = e->check.canonical;
    e->check.canonical = (struct sga_buf){ 0 };
    enum MHD_Result rc = submit(e, e->check.sum, &canonical);
    sga_buf_free(&canonical);
    return rc;
}

static enum MHD_Result post(struct exchange *e, long seconds)
{
    struct service *sv = e->service;
    if (e->job)
        return answer(e);             /* resumed */
    if (e->check.done)
        return checked(e, seconds);   /* resumed too */
    name_body(e);
    struct finished *f = memory_cache_by_body(sv->memory_cache, e->check.sum);
    if (f)
        return hit(e, f, METRIC_CACHE_MEMORY);
    if (!room_for_reading(e->length))
        return busy(e, "There is not enough memory to read a request at this moment.");
    return check_threads_submit(sv->check_threads, e) ? MHD_YES : busy(e, "Many requests wait to be read already.");
}

enum MHD_Result handle_post_job(struct exchange *e)
{
    return post(e, 0);
}

enum MHD_Result handle_solve(struct exchange *e)
{
    return post(e, SOLVE_SECONDS);
}
