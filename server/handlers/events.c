/* GET /v1/jobs/ID/events: server-sent events. A `progress` event for each change that the
 * client has not seen, then one `end` event with the job (without its result), id "end". A
 * client that comes back with Last-Event-ID: end gets 204, which tells it to stop. */
#include "budget.h"
#include "config.h"
#include "conns.h"
#include "finished.h"
#include "handlers.h"
#include "job.h"
#include "jobs.h"
#include "lookup.h"
#include "reply.h"
#include "service.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"

#define TYPE_EVENTS "text/event-stream"
static const double HEARTBEAT = 12;       /* seconds between signs of life */
enum { RETRY_MS = 2000 };

struct stream {
    struct service *service;
    struct job *job;
    struct waiter waiter;
    uint64_t seen;
    double heartbeat;
    struct sga_buf out;
    size_t sent;
    bool over;
};

static void put_end(struct sga_buf *out, const struct finished *f)
{
    sga_buf_puts(out, "event: end\nid: end\ndata: ");
    sga_buf_put(out, f->text, f->head);
    sga_buf_puts(out, "}\n\n");
}

static void put_progress(struct sga_buf *out, const struct job_look *look)
{
    struct sga_json w;
    sga_buf_printf(out, "event: progress\nid: %" PRIu64 "\ndata: ", look->event);
    sga_json_begin(&w, out);
    job_write(&w, &look->row, &look->progress);
    sga_buf_puts(out, "\n\n");
}

/* What there is to say now, into out. False: nothing. */
static bool fill(struct stream *s)
{
    struct job_look look;
    double now = sga_now();
    sga_buf_clear(&s->out);
    s->sent = 0;
    jobs_look(s->service->jobs, s->job, &look);
    bool news = look.event != s->seen || look.finished;
    if (look.finished) {
        put_end(&s->out, look.finished);
        s->over = true;
    } else if (look.gone) {
        s->over = true;
    } else if (news) {
        put_progress(&s->out, &look);
    } else if (now >= s->heartbeat) {
        sga_buf_puts(&s->out, ": still here\n\n");
    }
    s->seen = look.event;
    finished_unref(look.finished);
    if (s->out.len)
        s->heartbeat = now + HEARTBEAT;
    return s->out.len > 0;
}

static ssize_t read_stream(void *cls, uint64_t at, char *buf, size_t max)
{
    struct stream *s = cls;
    (void)at;
    while (s->sent == s->out.len) {
        if (s->over)
            return MHD_CONTENT_READER_END_OF_STREAM;
        if (fill(s))
            break;
        s->waiter.seen = s->seen;
        s->waiter.deadline = s->heartbeat;
        if (jobs_wait(s->service->jobs, s->job, &s->waiter))
            return 0;                 /* suspended: the stream may be read on another thread now */
        if (!fill(s))
            s->over = true;           /* it may not wait: the service closes */
        else
            break;
    }
    size_t n = s->out.len - s->sent;
    if (n > max)
        n = max;
    memcpy(buf, s->out.data + s->sent, n);
    s->sent += n;
    return n ? (ssize_t)n : MHD_CONTENT_READER_END_OF_STREAM;
}

static void free_stream(void *cls)
{
    struct stream *s = cls;
    jobs_stream_end(s->service->jobs, s->waiter.account);
    job_unref(s->job);
    sga_buf_free(&s->out);
    free(s);
}

static void stream_headers(struct exchange *e)
{
    reply_header(e, "Cache-Control", "no-store");
    reply_header(e, "X-Accel-Buffering", "no");
}

static enum MHD_Result ended(struct exchange *e, struct finished *f)
{
    struct sga_buf b = { 0 };
    const char *last = exchange_header(e, "Last-Event-ID");
    if (last && strcmp(last, "end") == 0) {
        finished_unref(f);
        return reply_empty(e, 204);
    }
    sga_buf_printf(&b, "retry: %d\n\n", RETRY_MS);
    put_end(&b, f);
    finished_unref(f);
    stream_headers(e);
    return reply_buf(e, 200, TYPE_EVENTS, &b);
}

static enum MHD_Result no_room(struct exchange *e, enum stream_room why)
{
    reply_header(e, "Retry-After", "10");
    if (why == STREAMS_FULL)
        return reply_error(e, SGA_E_QUEUE_FULL, "There are %ld event streams already. Ask for the job itself from time to time.",
                           atomic_load(&e->service->config->streams));
    return reply_error(e, SGA_E_QUOTA, "This token has used up its quota of requests that wait. Ask for the job itself from time to time.");
}

/* Of a place that was taken, which it owns from here on. */
static struct stream *stream_new(struct exchange *e)
{
    struct stream *s = calloc(1, sizeof *s);
    if (!s) {
        jobs_stream_end(e->service->jobs, e->account);
        return NULL;
    }
    const char *last = exchange_header(e, "Last-Event-ID");
    *s = (struct stream){ .service = e->service, .job = e->job, .seen = last ? strtoull(last, NULL, 10) : 0,
                          .waiter = { .connection = e->connection, .account = e->account, .kind = WAIT_EVENT }, .heartbeat = sga_now() + HEARTBEAT };
    job_ref(s->job);
    sga_buf_printf(&s->out, "retry: %d\n: events of job %s\n\n", RETRY_MS, job_id(s->job));
    return s;
}

enum MHD_Result handle_events(struct exchange *e)
{
    struct finished *f = NULL;
    enum lookup found = exchange_lookup(e, &f);
    if (f)
        return ended(e, f);
    if (found != LOOKUP_LIVE)
        return reply_lookup(e, found);
    enum stream_room room = jobs_stream_begin(e->service->jobs, e->account);
    if (room != STREAM_TAKEN)
        return no_room(e, room);
    stream_headers(e);
    if (strcmp(e->method, "HEAD") == 0) {
        jobs_stream_end(e->service->jobs, e->account);
        return reply_static(e, 200, TYPE_EVENTS, "", 0);
    }
    struct stream *s = stream_new(e);
    if (!s)
        return MHD_NO;
    struct MHD_Response *r = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, 4096, read_stream, s, free_stream);
    if (!r)
        free_stream(s);
    enum MHD_Result rc = reply_response(e, 200, TYPE_EVENTS, r);
    /* A reader that takes nothing any more is cut in the end; one that is alive comes back. */
    conn_deadline(e->conn, sga_now() + (double)e->service->config->stream_timeout);
    return rc;
}
