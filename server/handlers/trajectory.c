/* GET /v1/jobs/ID/trajectory: the samples alone. As JSON they are a piece of the finished
 * text and are sent as it stands; as CSV, NDJSON and for NumPy they are streamed row by row; as an image or a MAT-file, which
 * has columns, they are made whole. */
#include "config.h"
#include "finished.h"
#include "handlers.h"
#include "little_endian.h"
#include "lookup.h"
#include "motion_svg.h"
#include "result_part.h"
#include "samples.h"
#include "samples_files.h"
#include "service.h"
#include "view.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"

enum { NPY = VIEW_NDJSON + 1, MAT, SVG, FORMATS };
static const struct result_part_format formats[FORMATS] = {
    [VIEW_JSON] = { "json", TYPE_JSON },
    [VIEW_CSV] = { "csv", "text/csv" },
    [VIEW_NDJSON] = { "ndjson", "application/x-ndjson" },
    [NPY] = { "npy", "application/x-npy" },
    [MAT] = { "mat", "application/x-matlab-data" },
    [SVG] = { "svg", "image/svg+xml" },
};
static const struct result_part_kind kind = { "trajectory", "trajectories", formats, FORMATS, "json, csv, ndjson, npy, mat or svg", SGA_E_NO_TRAJECTORY,
                                        "The request of this job asked for no trajectory." };

struct flow {
    struct finished *finished;
    struct view view;            /* of lines */
    struct samples samples;      /* of numbers */
    double *row;                 /* of these; NULL: lines */
    struct sga_buf line;
    size_t sent;
};

static void free_flow(void *cls)
{
    struct flow *f = cls;
    view_close(&f->view);
    samples_end(&f->samples);
    free(f->row);
    sga_buf_free(&f->line);
    finished_unref(f->finished);
    free(f);
}

static bool next_line(struct flow *f)
{
    if (!f->row)
        return view_line(&f->view, &f->line);
    if (!samples_next(&f->samples, f->row))
        return false;
    little_doubles(&f->line, f->row, (size_t)f->samples.columns, 1);
    return true;
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
            if (!next_line(f))
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

static bool open_flow(struct flow *f, int format, struct slice trajectory)
{
    if (format != NPY)
        return view_open(&f->view, (enum view_format)format, trajectory);
    if (!samples_open(&f->samples, trajectory) || !(f->row = calloc((size_t)f->samples.columns + 1, sizeof *f->row)))
        return false;
    samples_npy_head(&f->samples, &f->line);
    return true;
}

static enum MHD_Result send_rows(struct exchange *e, struct finished *f, int format, struct slice trajectory)
{
    struct flow *flow = calloc(1, sizeof *flow);
    if (!flow) {
        finished_unref(f);
        return MHD_NO;
    }
    flow->finished = f;
    if (!open_flow(flow, format, trajectory)) {
        free_flow(flow);
        return MHD_NO;
    }
    return reply_stream(e, 200, format == (int)VIEW_CSV ? "text/csv; charset=utf-8; header=present" : formats[format].type, read_flow, free_flow, flow);
}

/* What was made whole, until it is sent. Its bytes count as those of results that are being sent do. */
struct whole {
    struct sga_buf text;
    atomic_long *booked;
    long bytes;
};

/* Bytes of a file or an image beside its values. */
enum { WHOLE_REST = 1 << 20 };

static void free_whole(void *cls)
{
    struct whole *w = cls;
    atomic_fetch_sub(w->booked, w->bytes);
    sga_buf_free(&w->text);
    free(w);
}

static ssize_t read_whole(void *cls, uint64_t at, char *buf, size_t max)
{
    const struct whole *w = cls;
    size_t n = w->text.len - (size_t)at < max ? w->text.len - (size_t)at : max;
    memcpy(buf, w->text.data + at, n);
    return (ssize_t)n;
}

static bool make_whole(struct exchange *e, int format, struct samples *s, struct sga_buf *out, struct sga_buf *why)
{
    if (!samples_take(s)) {
        sga_buf_puts(why, "The samples cannot be read.");
        return false;
    }
    if (format == SVG)
        return motion_svg(s, exchange_query(e, "columns"), exchange_query(e, "x"), out, why);
    sga_buf_room(out, s->rows * (size_t)s->columns * sizeof *s->value + WHOLE_REST);
    if (samples_mat(s, out))
        return true;
    sga_buf_puts(why, "The samples are longer than a MAT-file of level 5 can be: ask for npy, csv or ndjson.");
    return false;
}

/* The bytes of the table and of the file, before either is there. */
static long whole_bytes(const struct samples *s)
{
    return 2 * (long)(s->rows * (size_t)s->columns * sizeof *s->value) + WHOLE_REST;
}

static enum MHD_Result send_whole(struct exchange *e, struct finished *f, int format, struct slice trajectory)
{
    struct service *sv = e->service;
    struct whole *w = calloc(1, sizeof *w);
    struct sga_buf why = { 0 };
    struct samples s;
    if (!w || !samples_open(&s, trajectory)) {
        free(w);
        finished_unref(f);
        return MHD_NO;
    }
    w->booked = &sv->reply_bytes;
    w->bytes = whole_bytes(&s);
    bool full = atomic_fetch_add(w->booked, w->bytes) + w->bytes > atomic_load(&sv->config->reply_memory) + atomic_load(&sv->config->cache_memory);
    bool ok = !full && make_whole(e, format, &s, &w->text, &why);
    samples_end(&s);
    finished_unref(f);
    if (ok) {
        atomic_fetch_sub(w->booked, w->bytes - (long)w->text.cap);
        w->bytes = (long)w->text.cap;
        struct MHD_Response *r = MHD_create_response_from_callback(w->text.len, 32768, read_whole, w, free_whole);
        if (r)
            return reply_response(e, 200, formats[format].type, r);
    }
    enum MHD_Result rc = full ? reply_lookup(e, LOOKUP_BUSY) : ok ? MHD_NO : reply_error(e, SGA_E_BAD_REQUEST, "%s", why.data);
    free_whole(w);
    sga_buf_free(&why);
    return rc;
}

enum MHD_Result handle_trajectory(struct exchange *e)
{
    struct finished *f;
    struct slice trajectory;
    enum MHD_Result rc;
    int format;
    if (!result_part_find(e, &kind, &f, &trajectory, &format, &rc))
        return rc;
    if (format != SVG && (exchange_query(e, "columns") || exchange_query(e, "x"))) {
        finished_unref(f);
        return reply_error(e, SGA_E_BAD_REQUEST, "`columns` and `x` belong to an image: add format=svg.");
    }
    if (format > NPY)
        return send_whole(e, f, format, trajectory);
    return format == VIEW_JSON ? result_part_send(e, f, trajectory) : send_rows(e, f, format, trajectory);
}
