/* GET and DELETE of jobs, and their list. A job belongs to the tokens that asked for it: each finds
 * it in its list and may withdraw; it is cancelled where nobody else wants it, or by the scope
 * admin. Who knows its id knows the request (the id is a digest of it), and may read the job. */
#include "budget.h"
#include "config.h"
#include "finished.h"
#include "handlers.h"
#include "jobs.h"
#include "log.h"
#include "lookup.h"
#include "memory_cache.h"
#include "reply.h"
#include "service.h"
#include "store.h"
#include "tokens.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"

enum { PAGE = 50, PAGE_MAX = 500, CANCEL_SECONDS = 3 };

/* Takes over the reference. */
static enum MHD_Result ended(struct exchange *e, struct finished *f)
{
    if (!reply_tag(e, f->etag, f->len, ""))
        return reply_finished(e, 200, f, false);
    finished_unref(f);
    return reply_empty(e, 304);
}

/* A job that had not ended when it was found. */
static enum MHD_Result living(struct exchange *e)
{
    struct job_look look;
    if (e->wait_seconds > 0 && exchange_wait(e, WAIT_ENDED, e->wait_until))
        return MHD_YES;
    jobs_look(e->service->jobs, e->job, &look);
    if (e->wait_seconds > 0)
        reply_header(e, "Preference-Applied", "wait=%ld", e->wait_seconds);
    if (look.finished)
        return ended(e, look.finished);
    if (look.gone)
        return reply_lookup(e, LOOKUP_NONE);
    reply_header(e, "Retry-After", "1");
    return reply_job(e, 200, &look);
}

enum MHD_Result handle_get_job(struct exchange *e)
{
    struct finished *f = NULL;
    if (e->job)
        return living(e);             /* resumed */
    enum lookup found = exchange_lookup(e, &f);
    if (f)
        return ended(e, f);
    if (found != LOOKUP_LIVE)
        return reply_lookup(e, found);
    exchange_prefer(e, 0);
    return living(e);
}

/* A job that was asked to stop, once it has or its time is over. */
static enum MHD_Result cancelled(struct exchange *e)
{
    struct job_look look;
    if (exchange_wait(e, WAIT_ENDED, e->wait_until))
        return MHD_YES;
    jobs_look(e->service->jobs, e->job, &look);
    if (!look.finished)
        return reply_job(e, 202, &look);
    if (look.finished->status == JOB_CANCELLED)
        return reply_finished(e, 200, look.finished, false);
    enum job_status status = look.finished->status;
    finished_unref(look.finished);
    return reply_error(e, SGA_E_JOB_ENDED, "The job has ended already; its status is %s.", job_status_text(status));
}

/* An interest that was withdrawn, once that is on disk. */
static enum MHD_Result withdrawn(struct exchange *e)
{
    struct job_look look;
    if (!e->withdrawn) {
        e->withdrawn = true;
        job_unref(e->job);
        if (!(e->job = jobs_barrier(e->service->jobs)))
            return MHD_NO;
        e->wait_until = sga_now() + (double)e->service->config->store_timeout;
    }
    if (exchange_wait(e, WAIT_STORED, e->wait_until))
        return MHD_YES;
    jobs_look(e->service->jobs, e->job, &look);
    return look.stored == 1 ? reply_empty(e, 204) : reply_error(e, SGA_E_STORE, "That could not be written to the store. Try again later.");
}

/* For the audit: a job ends, or a place in a list goes, because somebody said so. */
static void tell(struct exchange *e, const char *event)
{
    char peer[PEER_TEXT];
    log_event(LOG_L_AUDIT, event, "job", e->segment, "token", *e->account->name ? e->account->name : NULL, "request_id", e->request_id,
              "peer", exchange_peer(e, peer), NULL);
}

/* A job that has ended: one's own place in the list goes. Where there are no tokens, and for
 * administrators who did not ask for it themselves, the job does. */
static enum MHD_Result delete_ended(struct exchange *e, enum job_status status)
{
    struct service *sv = e->service;
    bool own = store_owned(sv->store, e->segment, e->account->name) == STORE_FOUND;
    if (sv->tokens && own) {
        jobs_drop_interest(sv->jobs, e->segment, e->account);
        return withdrawn(e);
    }
    if (!sv->tokens || e->scopes & SCOPE_ADMIN) {
        store_forget(sv->store, e->segment);
        memory_cache_drop(sv->memory_cache, e->segment);
        tell(e, "job_removed");
        return withdrawn(e);
    }
    return reply_error(e, SGA_E_JOB_ENDED, "The job has ended already, and is not in this token's list; its status is %s.", job_status_text(status));
}

enum MHD_Result handle_delete(struct exchange *e)
{
    struct finished *f = NULL;
    struct job *job = NULL;
    if (e->job)                       /* resumed */
        return e->withdrawn ? withdrawn(e) : cancelled(e);
    enum lookup found = exchange_sees(e) ? lookup_job(e->service, e->segment, &job, &f) : LOOKUP_NONE;
    job_unref(job);
    if (f || found == LOOKUP_GONE) {
        enum job_status status = f ? f->status : JOB_DONE;
        finished_unref(f);
        return delete_ended(e, status);
    }
    if (found != LOOKUP_LIVE)
        return reply_lookup(e, found);
    enum cancel outcome = jobs_cancel(e->service->jobs, e->segment, e->scopes & SCOPE_ADMIN ? NULL : e->account, &e->job);
    if (outcome == CANCEL_NOT_YOURS)
        return reply_error(e, SGA_E_SCOPE, "This token did not ask for the job; to cancel it takes the scope admin.");
    if (outcome == CANCEL_BROKEN)
        return reply_error(e, SGA_E_STORE, "That could not be written to the store. Try again later.");
    if (outcome == CANCEL_UNKNOWN)
        return reply_error(e, SGA_E_JOB_ENDED, "The job has ended already.");
    tell(e, outcome == CANCEL_WITHDRAWN ? "job_withdrawn" : "job_cancelled");
    if (outcome == CANCEL_WITHDRAWN)
        return withdrawn(e);
    e->wait_until = sga_now() + CANCEL_SECONDS;
    return cancelled(e);
}

static bool number(const char *text, int64_t low, int64_t high, int64_t *out)
{
    char *end;
    if (!*text || strspn(text, "0123456789") != strlen(text) || strlen(text) > 18)
        return false;
    *out = strtoll(text, &end, 10);
    return *out >= low && *out <= high;
}

static bool read_statuses(const char *text, unsigned *out)
{
    *out = 0;
    for (const char *p = text; *p;) {
        size_t n = strcspn(p, ",");
        enum job_status s = job_status_from_text(p, n);
        if (s == JOB_STATUSES)
            return false;
        *out |= 1u << s;
        p += n + (p[n] == ',');
    }
    return *out != 0;
}

static bool read_query(struct exchange *e, struct store_query *q, struct sga_error *err)
{
    const char *limit = exchange_query(e, "limit"), *cursor = exchange_query(e, "cursor"), *status = exchange_query(e, "status");
    int64_t n = PAGE;
    *q = (struct store_query){ .statuses = (1u << JOB_STATUSES) - 1 };
    if (limit && !number(limit, 1, PAGE_MAX, &n))
        return sga_fail(err, SGA_E_BAD_REQUEST, "limit must be a whole number from 1 to %d.", PAGE_MAX);
    if (cursor && !number(cursor, 1, INT64_MAX, &q->before))
        return sga_fail(err, SGA_E_BAD_REQUEST, "cursor must be the `next` of an earlier page.");
    if (status && !read_statuses(status, &q->statuses))
        return sga_fail(err, SGA_E_BAD_REQUEST, "status must be one or more of queued, running, done, failed, cancelled, separated by commas.");
    q->limit = (int)n;
    q->owner = e->scopes & SCOPE_ADMIN ? NULL : e->account->name;
    return true;
}

static void write_item(struct exchange *e, struct sga_json *w, const struct job_row *row)
{
    struct job *live = row->status == JOB_RUNNING ? jobs_find(e->service->jobs, row->id) : NULL;
    struct job_look look;
    if (!live) {
        job_write(w, row, NULL);
        return;
    }
    jobs_look(e->service->jobs, live, &look);
    job_write(w, row, look.row.status == JOB_RUNNING ? &look.progress : NULL);
    finished_unref(look.finished);
    job_unref(live);
}

static enum MHD_Result write_page(struct exchange *e, const struct store_page *page, const struct store_query *q)
{
    struct sga_buf b = { 0 };
    struct sga_json w;
    sga_json_begin(&w, &b);
    sga_json_object(&w);
    sga_json_key(&w, "jobs");
    sga_json_array(&w);
    for (int i = 0; i < page->rows; i++)
        write_item(e, &w, &page->row[i]);
    sga_json_end_array(&w);
    sga_json_key(&w, "next");
    if (page->more) {
        char cursor[32];
        snprintf(cursor, sizeof cursor, "%" PRId64, page->row[page->rows - 1].seq);
        sga_json_string(&w, cursor);
        const char *status = exchange_query(e, "status");
        reply_header(e, "Link", "</v1/jobs?limit=%d&cursor=%s%s%s>; rel=\"next\"", q->limit, cursor,
                     status ? "&status=" : "", status ? status : "");
    } else {
        sga_json_null(&w);
    }
    sga_json_end_object(&w);
    reply_header(e, "Cache-Control", "no-store");
    return reply_buf(e, 200, TYPE_JSON, &b);
}

/* The list is read from the store; what was told to clients before is on disk first. */
enum MHD_Result handle_list(struct exchange *e)
{
    struct store_query q;
    struct store_page page;
    struct sga_error err = { 0 };
    if (!read_query(e, &q, &err))
        return reply_problem(e, &err);
    if (!e->job) {
        if (!(e->job = jobs_barrier(e->service->jobs)))
            return MHD_NO;
        if (exchange_wait(e, WAIT_STORED, sga_now() + (double)e->service->config->store_timeout))
            return MHD_YES;
    }
    if (store_list(e->service->store, &q, &page) != STORE_FOUND)
        return reply_error(e, SGA_E_STORE, "The jobs cannot be read from the store.");
    enum MHD_Result rc = write_page(e, &page, &q);
    store_page_free(&page);
    return rc;
}
