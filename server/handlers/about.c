/* What the service says about itself: health, readiness, metrics, schema, version. */
#include "config.h"
#include "conns.h"
#include "digest.h"
#include "embed.h"
#include "handlers.h"
#include "jobs.h"
#include "log.h"
#include "memory_cache.h"
#include "metrics.h"
#include "process.h"
#include "reply.h"
#include "run.h"
#include "service.h"
#include "store.h"
#include "tls.h"
#include "tokens.h"

#include <stdio.h>
#include <string.h>

#include "error.h"

static enum MHD_Result reply_text(struct exchange *e, const char *text)
{
    reply_header(e, "Cache-Control", "no-store");
    return reply_static(e, 200, TYPE_JSON, text, strlen(text));
}

enum MHD_Result handle_health(struct exchange *e)
{
    return reply_text(e, "{\"status\":\"ok\"}");
}

/* OK where jobs are accepted, else why not. */
static enum sga_code obstacle(struct service *sv, const struct jobs_counts *counts)
{
    if (jobs_draining(sv->jobs))
        return SGA_E_DRAINING;
    if (!store_healthy(sv->store))
        return SGA_E_STORE;
    if (counts->idle)
        return SGA_E_WORKER_DIED;
    return counts->full ? SGA_E_QUEUE_FULL : SGA_E_OK;
}

enum MHD_Result handle_ready(struct exchange *e)
{
    struct jobs_counts counts;
    jobs_count(e->service->jobs, &counts);
    enum sga_code code = obstacle(e->service, &counts);
    if (code == SGA_E_OK)
        return reply_text(e, "{\"status\":\"ready\"}");
    reply_header(e, "Retry-After", "5");
    if (code == SGA_E_WORKER_DIED)
        return reply_error(e, SGA_E_BUSY, "No process can be started to run jobs: they wait. The service's log says why.");
    return reply_error(e, code, "No jobs are accepted at present.");
}

enum MHD_Result handle_metrics(struct exchange *e)
{
    struct service *sv = e->service;
    struct sga_buf b = { 0 };
    struct jobs_counts counts;
    jobs_count(sv->jobs, &counts);
    struct metrics_now now = { counts.queued, counts.running, counts.queue_bytes, counts.waiters, counts.streams,
                               conns_count(sv->conns), store_healthy(sv->store), obstacle(sv, &counts) == SGA_E_OK, log_dropped(),
                               counts.ending, counts.ending_bytes, (unsigned long)tls_expires(),
                               counts.oldest, store_free_bytes(sv->store), store_bytes(sv->store, false), store_bytes(sv->store, true),
                               memory_cache_bytes(sv->memory_cache), sga_version() };
    metrics_write(sv->metrics, &now, sv->route_names, &b);
    if (!config_isolated(sv->config) || e->scopes & SCOPE_WATCH)
        jobs_write_accounts(sv->jobs, &b);
    process_write(&b);
    reply_header(e, "Cache-Control", "no-store");
    return reply_buf(e, 200, "text/plain; version=0.0.4; charset=utf-8", &b);
}

static enum MHD_Result reply_file(struct exchange *e, const char *name, const char *type)
{
    const struct embedded *f = embedded_find(name, strlen(name));
    if (!f)
        return reply_error(e, SGA_E_NOT_FOUND, "There is no schema of this name. There are request, check, result and problem.");
    unsigned char sum[DIGEST_BYTES];
    char etag[2 * 8 + 3];
    digest(sum, f->text, f->length);
    snprintf(etag, sizeof etag, "\"%02x%02x%02x%02x%02x%02x%02x%02x\"", sum[0], sum[1], sum[2], sum[3], sum[4], sum[5], sum[6], sum[7]);
    reply_header(e, "Cache-Control", "no-cache");
    return reply_tag(e, etag, f->length, "") ? reply_empty(e, 304) : reply_static(e, 200, type, f->text, f->length);
}

enum MHD_Result handle_openapi(struct exchange *e)
{
    return reply_file(e, "openapi", TYPE_JSON);
}

enum MHD_Result handle_schema(struct exchange *e)
{
    return reply_file(e, e->segment, "application/schema+json");
}

enum MHD_Result handle_version(struct exchange *e)
{
    struct sga_buf b = { 0 };
    struct sga_json w;
    sga_json_begin(&w, &b);
    sga_json_object(&w);
    sga_json_key(&w, "name"), sga_json_string(&w, "sgad");
    sga_json_key(&w, "version"), sga_json_string(&w, sga_version());
    sga_json_key(&w, "http"), sga_json_string(&w, MHD_get_version());
    sga_json_end_object(&w);
    return reply_buf(e, 200, TYPE_JSON, &b);
}
