/* Replies. */
#include "reply.h"
#include "budget.h"
#include "config.h"
#include "conns.h"
#include "exchange.h"
#include "finished.h"
#include "front.h"
#include "jobs.h"
#include "lookup.h"
#include "metrics.h"
#include "packed.h"
#include "prefer.h"
#include "problem.h"
#include "service.h"
#include "spool.h"
#include "store.h"
#include "tokens.h"

#include <assert.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"

enum { JOINED_MOST = 16384 };

void reply_header(struct exchange *e, const char *name, const char *fmt, ...)
{
    assert(e->headers < EXCHANGE_HEADERS);
    va_list ap;
    va_start(ap, fmt);
    e->header[e->headers].name = name;
    vsnprintf(e->header[e->headers].value, sizeof e->header->value, fmt, ap);
    va_end(ap);
    e->headers++;
}

static bool has_header(const struct exchange *e, const char *name)
{
    for (int i = 0; i < e->headers; i++)
        if (strcmp(e->header[i].name, name) == 0)
            return true;
    return false;
}

/* As it is: a header without a form costs a tenth of one with. */
static void plain_header(struct exchange *e, const char *name, const char *value, size_t n)
{
    assert(e->headers < EXCHANGE_HEADERS && n < sizeof e->header->value);
    e->header[e->headers].name = name;
    memcpy(e->header[e->headers].value, value, n);
    e->header[e->headers++].value[n] = 0;
}

enum MHD_Result reply_response(struct exchange *e, int status, const char *type, struct MHD_Response *response)
{
    if (!response)
        return MHD_NO;
    assert(status >= 100 && status < 600);
    if (type)
        MHD_add_response_header(response, "Content-Type", type);
    MHD_add_response_header(response, "X-Request-Id", e->request_id);
    MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
    for (int i = 0; i < e->headers; i++)
        MHD_add_response_header(response, e->header[i].name, e->header[i].value);
    if (atomic_load(&e->service->leaving) && !has_header(e, "Connection"))
        MHD_add_response_header(response, "Connection", "close");
    if (e->begun && !e->status)
        metrics_http(e->service->metrics, e->route_number, e->method, status);
    e->status = status;
    front_answered(conn_front(e->conn));
    conn_deadline(e->conn, sga_now() + (double)e->service->config->send_timeout);
    enum MHD_Result rc = MHD_queue_response(e->connection, (unsigned)status, response);
    MHD_destroy_response(response);
    return rc;
}

static void vary_header(struct exchange *e, const char *also)
{
    static const char name[] = "Accept-Encoding";
    if (*also)
        reply_header(e, "Vary", "%s%s", also, name);
    else
        plain_header(e, "Vary", name, sizeof name - 1);
}

bool reply_tag(struct exchange *e, const char *etag, size_t length, const char *vary)
{
    char tag[sizeof e->header->value];
    size_t n = strlen(etag);
    e->tagged = true;
    e->packs = length >= PACKED_LEAST && prefer_gzip(exchange_header(e, "Accept-Encoding")) && packed_room();
    assert(n + sizeof "-gzip" <= sizeof tag);
    memcpy(tag, etag, n + 1);
    if (e->packs)
        memcpy(tag + n - 1, "-gzip\"", sizeof "-gzip\"");
    plain_header(e, "ETag", tag, strlen(tag));
    if (length >= PACKED_LEAST)
        vary_header(e, vary);
    else if (*vary)
        reply_header(e, "Vary", "%.*s", (int)strlen(vary) - 2, vary);
    return reply_matches(e, tag);
}

/* A body without a tag: lists, states, counts. */
static void choose_packing(struct exchange *e, int status, size_t length)
{
    if (e->tagged || status >= 300 || length < PACKED_LEAST)
        return;
    e->packs = prefer_gzip(exchange_header(e, "Accept-Encoding")) && packed_room();
    vary_header(e, "");
}

/* The library sends the head and a buffer by one call to the system, the head and pieces by two: a call costs more than a
 * copy of this many bytes. NULL: they are more, or there is no memory. */
static struct MHD_Response *joined(const struct MHD_IoVec *part, int count)
{
    size_t length = 0;
    for (int i = 0; i < count; i++)
        length += part[i].iov_len;
    char *text = length && length <= JOINED_MOST ? malloc(length) : NULL, *end = text;
    for (int i = 0; text && i < count; i++) {
        if (part[i].iov_len)
            memcpy(end, part[i].iov_base, part[i].iov_len);
        end += part[i].iov_len;
    }
    struct MHD_Response *r = text ? MHD_create_response_from_buffer(length, text, MHD_RESPMEM_MUST_FREE) : NULL;
    if (!r)
        free(text);
    return r;
}

enum MHD_Result reply_pieces(struct exchange *e, int status, const char *type, const struct MHD_IoVec *part, int count,
                             MHD_ContentReaderFreeCallback release, void *cls)
{
    struct MHD_Response *r;
    size_t longest = 0;
    for (int i = 0; i < count; i++)
        longest = part[i].iov_len > longest ? part[i].iov_len : longest;
    if (e->packs) {
        reply_header(e, "Content-Encoding", "gzip");
        r = packed_pieces(part, count, release, cls);
    } else if (longest >= SPOOL_LONG) {
        r = plain_pieces(part, count, release, cls);
    } else if ((r = joined(part, count)) || !(r = MHD_create_response_from_iovec(part, (unsigned)count, release, cls))) {
        if (release)
            release(cls);
    }
    return reply_response(e, status, type, r);
}

enum MHD_Result reply_stream(struct exchange *e, int status, const char *type, MHD_ContentReaderCallback read,
                             MHD_ContentReaderFreeCallback release, void *cls)
{
    struct MHD_Response *r;
    if (e->packs) {
        reply_header(e, "Content-Encoding", "gzip");
        r = packed_response((struct packed_source){ read, release, cls });
    } else if (!(r = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, 32768, read, cls, release))) {
        release(cls);
    }
    return reply_response(e, status, type, r);
}

enum MHD_Result reply_buf(struct exchange *e, int status, const char *type, struct sga_buf *b)
{
    size_t length = b->len;
    char *text = sga_buf_take(b);
    choose_packing(e, status, length);
    if (e->packs)
        return reply_pieces(e, status, type, &(struct MHD_IoVec){ text, length }, 1, free, text);
    struct MHD_Response *r = MHD_create_response_from_buffer(length, text, MHD_RESPMEM_MUST_FREE);
    if (!r)
        free(text);
    return reply_response(e, status, type, r);
}

enum MHD_Result reply_static(struct exchange *e, int status, const char *type, const char *text, size_t length)
{
    if (e->packs && length)
        return reply_pieces(e, status, type, &(struct MHD_IoVec){ text, length }, 1, NULL, NULL);
    return reply_response(e, status, type, MHD_create_response_from_buffer(length, (void *)(uintptr_t)text, MHD_RESPMEM_PERSISTENT));
}

enum MHD_Result reply_empty(struct exchange *e, int status)
{
    return reply_static(e, status, NULL, "", 0);
}

enum MHD_Result reply_problem(struct exchange *e, const struct sga_error *err)
{
    struct sga_buf b = { 0 };
    struct sga_json w;
    metrics_refused(e->service->metrics, err->code);
    e->problem = err->code;
    e->packs = false;
    sga_json_begin(&w, &b);
    problem_write(&w, err);
    return reply_buf(e, sga_code_status(err->code), "application/problem+json", &b);
}

enum MHD_Result reply_error(struct exchange *e, enum sga_code code, const char *fmt, ...)
{
    struct sga_error err = { .code = code };
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(err.detail, sizeof err.detail, fmt, ap);
    va_end(ap);
    return reply_problem(e, &err);
}

enum MHD_Result reply_lookup(struct exchange *e, enum lookup outcome)
{
    struct sga_error err = lookup_error(outcome);
    if (outcome == LOOKUP_BUSY || outcome == LOOKUP_FULL)
        reply_header(e, "Retry-After", "%d", outcome == LOOKUP_BUSY ? 2 : 5);
    return reply_problem(e, &err);
}

bool exchange_sees(struct exchange *e)
{
    struct service *sv = e->service;
    return !config_isolated(sv->config) || e->scopes & SCOPE_ADMIN || jobs_asked(sv->jobs, e->segment, e->account)
        || store_owned(sv->store, e->segment, e->account->name) == STORE_FOUND;
}

enum lookup exchange_lookup(struct exchange *e, struct finished **f)
{
    if (!exchange_sees(e))
        return LOOKUP_NONE;
    return e->scopes & SCOPE_SUBMIT ? lookup_or_run(e->service, e->account, e->segment, &e->job, f)
                                    : lookup_job(e->service, e->segment, &e->job, f);
}

static void release(void *cls)
{
    finished_unref(cls);
}

enum MHD_Result reply_finished(struct exchange *e, int status, struct finished *f, bool cached)
{
    static const char yes[] = "true", no[] = "false";
    struct MHD_IoVec part[3] = {
        { f->text, f->cached_at },
        { cached ? yes : no, cached ? sizeof yes - 1 : sizeof no - 1 },
        { f->text + f->cached_at + sizeof no - 1, f->len - f->cached_at - (sizeof no - 1) },
    };
    assert(memcmp(f->text + f->cached_at, no, sizeof no - 1) == 0);       /* the word that is replaced */
    reply_header(e, "Cache-Control", "no-cache");
    return reply_pieces(e, status, TYPE_JSON, part, 3, release, f);
}

enum MHD_Result reply_job(struct exchange *e, int status, const struct job_look *look)
{
    struct sga_buf b = { 0 };
    struct sga_json w;
    sga_json_begin(&w, &b);
    job_write(&w, &look->row, &look->progress);
    reply_header(e, "Cache-Control", "no-store");
    return reply_buf(e, status, TYPE_JSON, &b);
}

/* The list of RFC 9110, 13.1.2: entity tags with commas, or *; W/ makes no difference here. */
bool reply_matches(struct exchange *e, const char *etag)
{
    const char *given = exchange_header(e, "If-None-Match");
    size_t n = strlen(etag);
    for (const char *p = given; p && *p;) {
        p += strspn(p, ", \t");
        if (*p == '*' || strncmp(p, etag, n) == 0 || (strncmp(p, "W/", 2) == 0 && strncmp(p + 2, etag, n) == 0))
            return true;
        p += strncmp(p, "W/", 2) == 0 ? 2 : 0;
        const char *close = *p == '"' ? strchr(p + 1, '"') : NULL;
        p = close ? close + 1 : p + strcspn(p, ",");
    }
    return false;
}
