/* GET /v1/jobs/ID/trajectory: the samples alone. As JSON they are a piece of the finished
 * text and are sent as it stands; as CSV and NDJSON they are streamed line by line. */
#include "handlers.h"
#include "result_part.h"
#include "view.h"

#include <stdlib.h>
#include <string.h>

static const struct result_part_format formats[VIEW_FORMATS] = {
    [VIEW_JSON] = { "json", TYPE_JSON },
    [VIEW_CSV] = { "csv", "text/csv" },
    [VIEW_NDJSON] = { "ndjson", "application/x-ndjson" },
};
static const struct result_part_kind kind = { "trajectory", "trajectories", formats, VIEW_FORMATS, "json, csv or ndjson", SGA_E_NO_TRAJECTORY,
                                        "The request of this job asked for no trajectory." };

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
    if (!view_open(&flow->view, format, trajectory)) {
        free_flow(flow);
        return MHD_NO;
    }
    return reply_stream(e, 200, format == VIEW_CSV ? "text/csv; charset=utf-8; header=present" : formats[format].type, read_flow, free_flow, flow);
}

enum MHD_Result handle_trajectory(struct exchange *e)
{
    struct finished *f;
    struct slice trajectory;
    enum MHD_Result rc;
    int format;
    if (!result_part_find(e, &kind, &f, &trajectory, &format, &rc))
        return rc;
    return format == VIEW_JSON ? result_part_send(e, f, trajectory) : send_lines(e, f, (enum view_format)format, trajectory);
}
