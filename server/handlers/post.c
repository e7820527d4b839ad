/* POST /v1/jobs and POST /v1/solve: from bytes to a job, or to its finished answer.
 *
 * A body seen before is answered from memory without reading it. Otherwise the library
 * checks it and makes the canonical text, whose digest is the job's id. A reply that
 * carries the end of a job does not wait for the disk; a 202 does. */
#include "budget.h"
#include "check_threads.h"
#include "handlers.h"
#include "lookup.h"
#include "memory_room.h"
#include "reply.h"
#include "run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SOLVE_SECONDS = 30, STORE_SECONDS = 60, RETRY_SECONDS = 1, FULL_SECONDS = 5 };

static enum MHD_Result hit(struct exchange *e, struct finished *f, enum metrics_counter from)
{
    metrics_add(&e->service->metrics, from);
    reply_header(e, "Location", "/v1/jobs/%s", f->id);
    reply_header(e, "ETag", "%s", f->etag);
    return reply_finished(e, 200, f, true);
}

/* The job in its present state: its end, or 202 once its row is on disk. */
static enum MHD_Result answer(struct exchange *e)
{
    struct service *sv = e->service;
    if (e->wait_seconds > 0 && exchange_wait(e, WAIT_ENDED, e->wait_until))
        return MHD_YES;
    struct job_look look;
    jobs_look(sv->jobs, e->job, &look);
    /* A 202 is a promise, also where the job was faster than the disk. */
    if (look.stored == 0 && (!look.finished || e->wait_seconds <= 0)) {
        finished_unref(look.finished);
        if (exchange_wait(e, WAIT_STORED, sga_now() + STORE_SECONDS))
            return MHD_YES;
        jobs_look(sv->jobs, e->job, &look);
    }
    reply_header(e, "Location", "/v1/jobs/%s", look.row.id);
    if (e->preferred)
        reply_header(e, "Preference-Applied", "wait=%ld", e->wait_seconds);
    if (look.finished) {
        reply_header(e, "ETag", "%s", look.finished->etag);
        /* Who did not wait is told 202 in any case, once the row is on disk. */
        if (e->wait_seconds > 0 || look.stored == 1)
            return reply_finished(e, e->wait_seconds > 0 ? 200 : 202, look.finished, false);
        finished_unref(look.finished);
    }
    reply_header(e, "Retry-After", "%d", RETRY_SECONDS);
    if (look.stored == 1)
        return reply_job(e, 202, &look);
    return jobs_draining(sv->jobs) ? reply_error(e, SGA_E_DRAINING, "The service is shutting down and could not keep the job.")
                                   : reply_error(e, SGA_E_STORE, "The job could not be written to the store.");
}

static enum MHD_Result refuse(struct exchange *e, enum submit why, const struct submission *s)
{
    const struct config *c = &e->service->config;
    switch (why) {
    case SUBMIT_DRAINING:
        reply_header(e, "Retry-After", "%d", FULL_SECONDS);
        return reply_error(e, SGA_E_DRAINING, "The service is shutting down. Try again later.");
    case SUBMIT_QUOTA:
        reply_header(e, "Retry-After", "%ld", s->retry);
        return reply_error(e, SGA_E_QUOTA, "This token has used up its quota of %s.", s->quota);
    case SUBMIT_FULL:
        reply_header(e, "Retry-After", "%d", FULL_SECONDS);
        return reply_error(e, SGA_E_QUEUE_FULL, "The queue holds as much as it may: %ld jobs, or %ld bytes of requests.",
                           atomic_load(&c->queue), atomic_load(&c->queue_bytes));
    default:
        return reply_error(e, SGA_E_INTERNAL, "There is not enough memory for another job.");
    }
}

/* A checked request: answered, refused, or a job in e->job. */
static enum MHD_Result submit(struct exchange *e, const unsigned char *sum, struct sga_buf *canonical)
{
    struct service *sv = e->service;
    char id[ID_LENGTH + 1];
    struct finished *f = NULL;
    size_t length = canonical->len;
    exchange_free_body(e);            /* who waits holds no memory for what is known already */
    digest_id(id, sga_version(), canonical->data, length);
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
    struct submission s = { .id = id, .request = sga_buf_take(canonical), .length = length, .account = e->account,
                            .request_id = e->request_id, .traceparent = e->traceparent };
    enum submit outcome = jobs_submit(sv->jobs, &s);
    free(s.request);
    if (outcome == SUBMIT_DONE)
        return hit(e, s.finished, METRIC_CACHE_MEMORY);
    if (outcome != SUBMIT_NEW && outcome != SUBMIT_JOINED)
        return refuse(e, outcome, &s);
    e->job = s.job;
    metrics_add(&sv->metrics, METRIC_CACHE_MISSES);
    return answer(e);
}

static enum MHD_Result busy(struct exchange *e, const char *why)
{
    reply_header(e, "Retry-After", "%d", FULL_SECONDS);
    return reply_error(e, SGA_E_BUSY, "%s Try again soon.", why);
}

/* The body was checked: here, or on another thread. */
static enum MHD_Result checked(struct exchange *e, long seconds)
{
    exchange_prefer(e, seconds);
    if (!e->check.ok) {
        if (e->check.err.code == SGA_E_DRAINING)
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
    digest(e->check.sum, e->body, e->length);
    struct finished *f = memory_cache_by_body(sv->memory_cache, e->check.sum);
    if (f)
        return hit(e, f, METRIC_CACHE_MEMORY);
    if (!room_for_reading(e->length))
        return busy(e, "There is not enough memory to read a request at this moment.");
    if (sv->check_threads && e->length > CHECK_THREADS_INLINE)
        return check_threads_submit(sv->check_threads, e) ? MHD_YES : busy(e, "Many requests wait to be read already.");
    e->check.ok = sga_canonical((const char *)e->body, e->length, &e->check.canonical, &e->check.err);
    return checked(e, seconds);
}

enum MHD_Result handle_post_job(struct exchange *e)
{
    return post(e, 0);
}

enum MHD_Result handle_solve(struct exchange *e)
{
    return post(e, SOLVE_SECONDS);
}
