/* Paths, with the scope that reading them needs (0: none, for probes and descriptions), and the
 * parameters that they take. The order is that of the metrics' labels. */
#include "routes.h"

#include <stdio.h>
#include <string.h>

#include "metrics.h"
#include "tokens.h"

#define ROUTES(X) \
    X("/v1/jobs",              SCOPE_READ, handle_list,       handle_post_job, NULL, "limit cursor status") \
    X("/v1/solve",             SCOPE_READ, NULL,              handle_solve,    NULL, "") \
    X("/v1/jobs/*",            SCOPE_READ, handle_get_job,    NULL,            handle_delete, "") \
    X("/v1/check",             SCOPE_READ, NULL,              handle_check,    NULL, "") \
    X("/v1/jobs/*/request",    SCOPE_READ, handle_request,    NULL,            NULL, "") \
    X("/v1/jobs/*/events",     SCOPE_READ, handle_events,     NULL,            NULL, "") \
    X("/v1/jobs/*/trajectory", SCOPE_READ, handle_trajectory, NULL,            NULL, "format columns x") \
    X("/v1/jobs/*/tradeoff",   SCOPE_READ, handle_tradeoff,   NULL,            NULL, "format") \
    X("/v1/jobs/*/code",       SCOPE_READ, handle_code,       NULL,            NULL, "language") \
    X("/v1/jobs/*/fmu",        SCOPE_READ, handle_fmu,        NULL,            NULL, "") \
    X("/healthz",              0,          handle_health,     NULL,            NULL, "") \
    X("/readyz",               0,          handle_ready,      NULL,            NULL, "") \
    X("/metrics",              SCOPE_WATCH, handle_metrics,    NULL,            NULL, "") \
    X("/openapi.json",         0,          handle_openapi,    NULL,            NULL, "") \
    X("/v1/schema/*",          0,          handle_schema,     NULL,            NULL, "") \
    X("/",                     0,          handle_page,       NULL,            NULL, "") \
    X("/page/*",               0,          handle_page,       NULL,            NULL, "") \
    X("/version",              0,          handle_version,    NULL,            NULL, "")

static const struct route routes[] = {
#define X(pattern, scope, get, post, remove, query) { pattern, scope, get, post, remove, query },
    ROUTES(X)
#undef X
};
enum { COUNT = sizeof routes / sizeof *routes };

const char *const route_names[] = {
#define X(pattern, scope, get, post, remove, query) pattern,
    ROUTES(X)
#undef X
    "other", NULL
};

_Static_assert(COUNT + 1 <= METRICS_ROUTES, "metrics count each route");

static bool matches(const char *pattern, const char *path, char *segment, size_t size)
{
    for (; *pattern; pattern++) {
        if (*pattern != '*') {
            if (*path++ != *pattern)
                return false;
            continue;
        }
        size_t n = strcspn(path, "/");
        if (n == 0 || n >= size)
            return false;
        memcpy(segment, path, n);
        segment[n] = 0;
        path += n;
    }
    return *path == 0;
}

const struct route *route_find(const char *path, char *segment, size_t size)
{
    for (int i = 0; i < COUNT; i++)
        if (matches(routes[i].pattern, path, segment, size))
            return &routes[i];
    return NULL;
}

handler *route_handler(const struct route *r, const char *method)
{
    if (strcmp(method, "GET") == 0 || strcmp(method, "HEAD") == 0)
        return r->get;
    if (strcmp(method, "POST") == 0)
        return r->post;
    return strcmp(method, "DELETE") == 0 ? r->remove : NULL;
}

unsigned route_scope(const struct route *r, const char *method)
{
    bool changes = strcmp(method, "POST") == 0 || strcmp(method, "DELETE") == 0;
    return changes && r->post != handle_check ? SCOPE_SUBMIT : r->scope;
}

void route_allow(const struct route *r, char *out, size_t size)
{
    snprintf(out, size, "%s%s%s", r->get ? "GET, HEAD" : "", r->post ? (r->get ? ", POST" : "POST") : "",
             r->remove ? (r->get || r->post ? ", DELETE" : "DELETE") : "");
}

int route_number(const struct route *r)
{
    return r ? (int)(r - routes) : COUNT;
}
