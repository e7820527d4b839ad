/* GET /v1/jobs/ID/code: a finished answer as source of another language; GET /v1/jobs/ID/fmu: as an FMU. It is written anew each time: the store has what it takes. */
#include "code_view.h"
#include "digest.h"
#include "finished.h"
#include "handlers.h"
#include "lookup.h"
#include "reply.h"
#include "run.h"
#include "service.h"
#include "store.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"

static bool choose(struct exchange *e, int *l, enum MHD_Result *rc)
{
    const char *name = exchange_query(e, "language");
    *l = name ? code_format_find(name) : CODE_FORMATS;
    if (*l != CODE_FORMATS)
        return true;
    struct sga_buf list = { 0 };
    for (int i = 0; i < CODE_FORMATS; i++)
        sga_buf_printf(&list, "%s%s", i ? ", " : "", code_format_name(i));
    *rc = reply_error(e, SGA_E_BAD_REQUEST, "language must be one of: %s.", list.data);
    sga_buf_free(&list);
    return false;
}

/* The answer of a job that has ended; NULL: *rc is the reply. */
static struct finished *find(struct exchange *e, enum MHD_Result *rc)
{
    struct finished *f = NULL;
    enum lookup found = exchange_lookup(e, &f);
    if (found == LOOKUP_LIVE) {
        reply_header(e, "Retry-After", "1");
        *rc = reply_error(e, SGA_E_NO_CODE, "The job has not ended yet.");
    } else if (!f) {
        *rc = reply_lookup(e, found);
    } else if (!f->result.at) {
        finished_unref(f);
        f = NULL;
        *rc = reply_error(e, SGA_E_NO_CODE, "The job has no result.");
    }
    return f;
}

/* Takes over the reference. */
static enum MHD_Result write_code(struct exchange *e, struct finished *f, int l)
{
    char *request = NULL;
    size_t length = 0;
    struct sga_error err = { 0 };
    struct sga_buf out = { 0 }, plain = { 0 };
    enum store_answer found = store_request(e->service->store, e->segment, &request, &length);
    bool ok = found == STORE_FOUND && sga_plain(request, length, &plain, &err)
        && code_view((struct slice){ plain.data, plain.len }, f->result, (struct code_origin){ e->segment, sga_version() }, l, &out, &err);
    finished_unref(f);
    free(request);
    sga_buf_free(&plain);
    if (found != STORE_FOUND)
        return reply_lookup(e, found == STORE_NONE ? LOOKUP_NONE : LOOKUP_BROKEN);
    if (!ok) {
        sga_buf_free(&out);
        return reply_problem(e, &err);
    }
    if (l == CODE_FMU)
        reply_header(e, "Content-Disposition", "attachment; filename=\"sga_model.fmu\"");
    return reply_buf(e, 200, code_format_type(l), &out);
}

static enum MHD_Result send_code(struct exchange *e, int l)
{
    enum MHD_Result rc;
    struct finished *f = find(e, &rc);
    if (!f)
        return rc;
    char etag[sizeof f->etag + 16];
    snprintf(etag, sizeof etag, "%.*s-%s\"", (int)strlen(f->etag) - 1, f->etag, code_format_name(l));
    reply_header(e, "Cache-Control", "no-cache");
    if (!reply_tag(e, etag, SIZE_MAX, ""))
        return write_code(e, f, l);
    finished_unref(f);
    return reply_empty(e, 304);
}

enum MHD_Result handle_code(struct exchange *e)
{
    int l;
    enum MHD_Result rc;
    return choose(e, &l, &rc) ? send_code(e, l) : rc;
}

enum MHD_Result handle_fmu(struct exchange *e)
{
    return send_code(e, CODE_FMU);
}
