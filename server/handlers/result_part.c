/* A member of a result as a resource: which format, where it is, or why it is not there. */
#include "result_part.h"

#include <stdio.h>
#include <string.h>

#include "error.h"
#include "finished.h"
#include "lookup.h"
#include "prefer.h"

/* By ?format=, else by Accept. -1: refused, and *rc is the reply's. */
static int choose(struct exchange *e, const struct result_part_kind *kind, enum MHD_Result *rc)
{
    const char *name = exchange_query(e, "format"), *types[RESULT_PART_FORMATS];
    for (int i = 0; i < kind->formats; i++) {
        types[i] = kind->format[i].type;
        if (name && strcmp(name, kind->format[i].name) == 0)
            return i;
    }
    if (name) {
        *rc = reply_error(e, SGA_E_BAD_REQUEST, "format must be %s.", kind->choices);
        return -1;
    }
    int best = prefer_type(exchange_header(e, "Accept"), types, kind->formats);
    if (best >= 0)
        return best;
    struct sga_buf list = { 0 };
    for (int i = 0; i < kind->formats; i++)
        sga_buf_printf(&list, "%s%s", i == 0 ? "" : i == kind->formats - 1 ? " or " : ", ", types[i]);
    *rc = reply_error(e, SGA_E_NOT_ACCEPTABLE, "A %s is sent as %s.", kind->member, list.data);
    sga_buf_free(&list);
    return -1;
}

static void release(void *cls)
{
    finished_unref(cls);
}

enum MHD_Result result_part_send(struct exchange *e, struct finished *f, struct slice part)
{
    struct MHD_IoVec whole = { part.at, part.len };
    return reply_pieces(e, 200, TYPE_JSON, &whole, 1, release, f);
}

bool result_part_find(struct exchange *e, const struct result_part_kind *kind, struct finished **out, struct slice *part,
                      int *format, enum MHD_Result *rc)
{
    struct finished *f = NULL;
    if ((*format = choose(e, kind, rc)) < 0)
        return false;
    enum lookup found = exchange_lookup(e, &f);
    if (found == LOOKUP_LIVE) {
        reply_header(e, "Retry-After", "1");
        *rc = reply_error(e, kind->missing, "The job has not ended yet.");
        return false;
    }
    if (!f) {
        *rc = reply_lookup(e, found);
        return false;
    }
    *part = f->result.at ? scan_member(f->result, kind->member) : (struct slice){ NULL, 0 };
    bool list = kind->list && !part->at && f->result.at;
    if (list)
        *part = scan_member(f->result, kind->list);
    if (!part->at || *part->at != (list ? '[' : '{')) {
        bool done = f->status == JOB_DONE;
        finished_unref(f);
        *rc = reply_error(e, kind->missing, "%s", done ? kind->not_asked : "The job has no result.");
        return false;
    }
    char etag[sizeof f->etag + 8];
    snprintf(etag, sizeof etag, "%.*s-%s\"", (int)strlen(f->etag) - 1, f->etag, kind->format[*format].name);
    reply_header(e, "Cache-Control", "no-cache");
    if (reply_tag(e, etag, part->len, "Accept, ")) {
        finished_unref(f);
        *rc = reply_empty(e, 304);
        return false;
    }
    *out = f;
    return true;
}
