/* GET /v1/jobs/ID/trajectory: the samples alone. As JSON they are a piece of the finished
 * text and are sent as it stands; as CSV and NDJSON they are streamed line by line. */
#include "lookup.h"
#include "prefer.h"
#include "reply.h"
#include "routes.h"
#include "view.h"

#include <stdlib.h>
#include <string.h>

static const struct { const char *name, *type; } formats[VIEW_FORMATS] = {
    [VIEW_JSON] = { "json", TYPE_JSON },
    [VIEW_CSV] = { "csv", "text/csv" },
    [VIEW_NDJSON] = { "ndjson", "application/x-ndjson" },
};

struct flow {
    struct finished *finished;
    struct view view;
    struct sga_buf line;
    size_t sent;
};

static void free_flow(void *cls)
{
    struct flow *f = cls;
    view_close(&f->view);
    sga_buf_free(&f->line);
    finished_unref(f->finished);
    free(f);
}

static ssize_t read_flow(void *cls, uint64_t at, char *buf, size_t max)
{
    struct flow *f = cls;
    size_t n = 0;
    (void)at;
    while (n < max) {
        if (f->sent == f->line.len) {
            sga_buf_clear(&f->line);
            f->sent = 0;
            if (!view_line(&f->view, &f->line))
                break;
        }
        size_t part = f->line.len - f->sent;
        if (part > max - n)
            part = max - n;
        memcpy(buf + n, f->line.data + f->sent, part);
        f->sent += part;
        n += part;
    }
    return n ? (ssize_t)n : MHD_CONTENT_READER_END_OF_STREAM;
}

static enum MHD_Result send_lines(struct exchange *e, struct finished *f, enum view_format format, struct slice trajectory)
{
    struct flow *flow = calloc(1, sizeof *flow);
    if (!flow) {
        finished_unref(f);
        return MHD_NO;
    }
    flow->finished = f;
    struct MHD_Response *r = NULL;
    if (view_open(&flow->view, format, trajectory))
        r = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, 32768, read_flow, flow, free_flow);
    if (!r)
        free_flow(flow);
    return reply_response(e, 200, format == VIEW_CSV ? "text/csv; charset=utf-8; header=present" : formats[format].type, r);
}

static void release(void *cls)
{
    finished_unref(cls);
}

static enum MHD_Result send_piece(struct exchange *e, struct finished *f, struct slice trajectory)
{
    struct MHD_IoVec part = { trajectory.at, trajectory.len };
    struct MHD_Response *r = MHD_create_response_from_iovec(&part, 1, release, f);
    if (!r)
        finished_unref(f);
    return reply_response(e, 200, TYPE_JSON, r);
}

/* By ?format=, else by Accept. False: refused, and *rc is the reply's. */
static bool choose(struct exchange *e, enum view_format *format, enum MHD_Result *rc)
{
    const char *name = exchange_query(e, "format"), *types[VIEW_FORMATS];
    for (int i = 0; i < VIEW_FORMATS; i++) {
        types[i] = formats[i].type;
        *format = (enum view_format)i;
        if (name && strcmp(name, formats[i].name) == 0)
            return true;
    }
    if (name) {
        *rc = reply_error(e, SGA_E_BAD_REQUEST, "format must be json, csv or ndjson.");
        return false;
    }
    int best = prefer_type(exchange_header(e, "Accept"), types, VIEW_FORMATS);
    if (best < 0) {
        *rc = reply_error(e, SGA_E_NOT_ACCEPTABLE, "A trajectory is sent as application/json, text/csv or application/x-ndjson.");
        return false;
    }
    *format = (enum view_format)best;
    return true;
}

enum MHD_Result handle_trajectory(struct exchange *e)
{
    struct finished *f = NULL;
    enum view_format format;
    enum MHD_Result rc;
    if (!choose(e, &format, &rc))
        return rc;
    enum lookup found = lookup_or_run(e->service, e->account, e->segment, &e->job, &f);
    if (found == LOOKUP_LIVE) {
        reply_header(e, "Retry-After", "1");
        return reply_error(e, SGA_E_NO_TRAJECTORY, "The job has not ended yet.");
    }
    if (!f) {
        struct sga_error err = lookup_error(found);
        return reply_problem(e, &err);
    }
    struct slice trajectory = f->result.at ? scan_member(f->result, "trajectory") : (struct slice){ NULL, 0 };
    if (!trajectory.at || *trajectory.at != '{') {
        bool done = f->status == JOB_DONE;
        finished_unref(f);
        return reply_error(e, SGA_E_NO_TRAJECTORY, done ? "The request of this job asked for no trajectory." : "The job has no result.");
    }
    char etag[sizeof f->etag + 8];
    snprintf(etag, sizeof etag, "%.*s-%s\"", (int)strlen(f->etag) - 1, f->etag, formats[format].name);
    reply_header(e, "ETag", "%s", etag);
    reply_header(e, "Vary", "Accept");
    reply_header(e, "Cache-Control", "no-cache");
    if (reply_matches(e, etag)) {
        finished_unref(f);
        return reply_empty(e, 304);
    }
    return format == VIEW_JSON ? send_piece(e, f, trajectory) : send_lines(e, f, format, trajectory);
}
