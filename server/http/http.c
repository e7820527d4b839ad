/* The HTTP library: its options and its callbacks.
 *
 * Internal polling with two threads and poll: epoll mode goes silent at 128 connections,
 * select fails past FD_SETSIZE, and one thread alone has long tails. A handler that must
 * wait suspends its connection; the jobs table resumes it. */
#include "http.h"
#include "admission.h"
#include "budget.h"
#include "caller.h"
#include "config.h"
#include "conns.h"
#include "front.h"
#include "jobs.h"
#include "listen.h"
#include "metrics.h"
#include "service.h"
#include "tls.h"
#include "log.h"
#include "reply.h"
#include "routes.h"
#include "ticker.h"
#include "turned_away.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#include "error.h"

enum { POOL = 2, CUT_MS = 1000, STOP_MS = 5000, BUSY_SECONDS = 2, LEAVE_LOOK_MS = 20, LEAVE_SURE = 5, LEAVE_REST_MS = 200, SPARE = 256 };     /* SPARE: connections that have been cut and are not closed yet */

/* A listening socket, for the callbacks that come by it. */
struct door {
    struct service *service;
    int number;
};

struct http {
    struct service *service;
    struct door door[LISTEN_MOST];
    struct MHD_Daemon *daemon[LISTEN_MOST];      /* one for each listening socket */
    struct ticker ticker;
    bool ticks, quiet;                           /* the ticker runs; no connection is taken */
    struct listeners listeners;
    char url[LISTEN_MOST * 322];
};

/* -- The life of a connection and of an exchange -- */

static void on_connection(void *cls, struct MHD_Connection *connection, void **ctx, enum MHD_ConnectionNotificationCode what)
{
    const struct door *door = cls;
    struct service *sv = door->service;
    if (what == MHD_CONNECTION_NOTIFY_CLOSED) {
        conn_remove(sv->conns, *ctx);
        *ctx = NULL;
        return;
    }
    /* Each is read before the next is asked for: newer libraries give them all at one place. */
    int fd = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    const union MHD_ConnectionInfo *info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_GNUTLS_SESSION);
    void *session = info ? info->tls_session : NULL;
    info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    bool gave = false;
    *ctx = conn_add(sv->conns, fd, session, door->number, info ? info->client_addr : NULL,
                    sga_now() + (double)sv->config->request_timeout, &gave);
    if (gave)
        metrics_add(sv->metrics, METRIC_PLACES_GIVEN);
    if (!*ctx) {
        metrics_add(sv->metrics, METRIC_LOST_CONNECTIONS);
        shutdown(fd, SHUT_RDWR);
    }
}

/* Called with the request line, before anything else: here the path is still as sent. */
static void *on_request_line(void *cls, const char *uri, struct MHD_Connection *connection)
{
    struct service *sv = cls;
    struct exchange *e = calloc(1, sizeof *e);
    if (!e) {
        metrics_add(sv->metrics, METRIC_LOST_CONNECTIONS);
        return NULL;
    }
    e->service = sv;
    e->connection = connection;
    e->began = sga_now();
    e->route_number = route_number(NULL);
    size_t path = strcspn(uri, "?");
    const char *zero = strstr(uri, "%00");
    e->bad_path = zero && (size_t)(zero - uri) < path;
    atomic_fetch_add(&sv->exchanges, 1);
    return e;
}

static void log_exchange(struct exchange *e, double seconds)
{
    bool probe = e->route && (e->route->get == handle_health || e->route->get == handle_ready || e->route->get == handle_metrics);
    enum log_level level = probe ? LOG_L_DEBUG : LOG_L_INFO;
    if (!log_wants(level))
        return;
    char status[16], took[32], peer[PEER_TEXT];
    snprintf(status, sizeof status, "%d", e->status);
    snprintf(took, sizeof took, "%.6f", seconds);
    log_event(level, "request", "request_id", e->request_id, "method", e->method,
              "route", route_names[e->route_number], "peer", exchange_peer(e, peer), "#status", status,
              "code", e->problem ? sga_code_text(e->problem) : NULL, "#seconds", took,
              "job", e->job ? job_id(e->job) : NULL, "token", e->account && *e->account->name ? e->account->name : NULL,
              "traceparent", *e->traceparent ? e->traceparent : NULL, NULL);
}

static void on_completed(void *cls, struct MHD_Connection *connection, void **con_cls, enum MHD_RequestTerminationCode how)
{
    struct service *sv = cls;
    struct exchange *e = *con_cls;
    (void)connection;
    (void)how;
    if (!e)
        return;
    *con_cls = NULL;
    double seconds = sga_now() - e->began;
    if (e->begun && !front_refused(conn_front(e->conn))) {
        if (!e->status)    /* nobody is left to answer */
            metrics_http(sv->metrics, e->route_number, e->method, 0);
        metrics_http_took(sv->metrics, seconds);
        log_exchange(e, seconds);
    }
    conn_deadline(e->conn, sga_now() + (double)sv->config->request_timeout);    /* for the next request */
    conn_busy(e->conn, false);
    job_unref(e->job);
    exchange_free_body(e);
    free(e);
    atomic_fetch_sub(&sv->exchanges, 1);
}

/* -- Reading a request -- */

/* The client's id where it is short and plain, ours otherwise. */
static void name_request(struct exchange *e)
{
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.:/+=";
    const char *given = exchange_header(e, "X-Request-Id"), *trace = exchange_header(e, "traceparent");
    size_t n = given ? strlen(given) : 0;
    if (n > 0 && n <= 64 && strspn(given, plain) == n)
        memcpy(e->request_id, given, n + 1);
    else
        request_name(e->service, e->request_id, sizeof e->request_id);
    if (trace && strlen(trace) < sizeof e->traceparent && strspn(trace, "0123456789abcdef-") == strlen(trace))
        strcpy(e->traceparent, trace);
}

/* The path of a target in absolute form (RFC 9112, 3.2.2), as proxies send it. Its host counts as
 * little as its scheme: the Host header was looked at. */
static const char *without_authority(const char *target)
{
    size_t scheme = strncasecmp(target, "http://", 7) == 0 ? 7 : strncasecmp(target, "https://", 8) == 0 ? 8 : 0;
    const char *slash = scheme ? strchr(target + scheme, '/') : target;
    return slash ? slash : "/";
}

/* Finds what answers this path and method. False with err filled. */
static bool find_route(struct exchange *e, const char *path, struct sga_error *err)
{
    path = without_authority(path);
    e->route = route_find(path, e->segment, sizeof e->segment);
    e->route_number = route_number(e->route);
    if (!e->route)
        return sga_fail(err, SGA_E_NOT_FOUND, "There is nothing at this path. /openapi.json lists what there is.");
    if (!route_handler(e->route, e->method)) {
        char allow[64];
        route_allow(e->route, allow, sizeof allow);
        reply_header(e, "Allow", "%s", allow);
        return sga_fail(err, SGA_E_METHOD, "This path allows %s.", allow);
    }
    if (!caller_admit(e, route_scope(e->route, e->method), err) || !admit_query(e, e->route->query, err))
        return false;
    return strcmp(e->method, "POST") != 0 || admit_body(e, err);
}

/* The headers have come. MHD_YES without a reply: go on with the body, if there is one. */
static enum MHD_Result begin(struct exchange *e, const char *path, const char *method)
{
    struct sga_error err = { 0 };
    const union MHD_ConnectionInfo *ctx = MHD_get_connection_info(e->connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    e->begun = true;
    e->conn = ctx ? ctx->socket_context : NULL;
    snprintf(e->method, sizeof e->method, "%s", method);
    if (!front_begin(conn_front(e->conn))) {
        log_event(LOG_L_ERROR, "request_past_front", NULL);
        return MHD_NO;
    }
    conn_busy(e->conn, true);
    name_request(e);
    bool admitted = admit(e, method, &err);
    if (!admitted || e->last)
        reply_header(e, "Connection", "close");
    if (!admitted)
        return reply_problem(e, &err);
    if (find_route(e, path, &e->refusal) || admit_drop(e))
        return MHD_YES;
    return reply_problem(e, &e->refusal);
}

/* A piece of the body. That of a request refused already is dropped, so that a client which
 * reads only after it has written gets its answer; but not without end. */
static enum MHD_Result take(struct exchange *e, const char *data, size_t n)
{
    size_t limit = (size_t)e->service->config->body_limit;
    e->received += n;
    if (e->received > limit)
        sga_fail(&e->refusal, SGA_E_BODY_TOO_LARGE, "The body may have at most %zu bytes.", limit);
    if (e->refusal.code != SGA_E_OK)
        return e->received <= ADMIT_DROP_FACTOR * limit ? MHD_YES : MHD_NO;
    if (e->length + n > e->capacity) {
        size_t want = e->capacity ? 2 * e->capacity : 4096;
        while (want < e->length + n)
            want *= 2;
        if (!exchange_grow(e, want))
            return MHD_YES;
        unsigned char *grown = realloc(e->body, want);
        if (!grown) {
            atomic_fetch_sub(&e->service->body_bytes, (long)(want - e->capacity));
            return MHD_NO;
        }
        e->body = grown;
        e->capacity = want;
    }
    memcpy(e->body + e->length, data, n);
    e->length += n;
    return MHD_YES;
}

static enum MHD_Result on_request(void *cls, struct MHD_Connection *connection, const char *path, const char *method,
                                  const char *version, const char *data, size_t *size, void **con_cls)
{
    struct exchange *e = *con_cls;
    (void)cls;
    (void)connection;
    (void)version;
    if (!e)
        return MHD_NO;
    if (!e->begun)
        return begin(e, path, method);
    if (*size) {
        size_t n = *size;
        *size = 0;
        return take(e, data, n);
    }
    if (e->refusal.code == SGA_E_BUSY)
        reply_header(e, "Retry-After", "%d", BUSY_SECONDS);
    if (e->refusal.code != SGA_E_OK)
        return reply_problem(e, &e->refusal);
    return route_handler(e->route, e->method)(e);
}

/* -- Starting and stopping -- */

static void log_library(void *cls, const char *fmt, va_list ap)
{
    char text[512];
    (void)cls;
    vsnprintf(text, sizeof text, fmt, ap);
    log_event(LOG_L_DEBUG, "http_library", "message", text, NULL);
}

static struct MHD_Daemon *start_daemon(struct http *h, int number)
{
    struct service *sv = h->service;
    const struct listening *l = &h->listeners.at[number];
    bool secure = tls_on() && !l->local;
    unsigned flags = MHD_USE_POLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ITC | MHD_USE_ERROR_LOG;
    struct MHD_OptionItem tls[] = {
        { MHD_OPTION_HTTPS_CERT_CALLBACK, 0, tls_retrieve() },
        { MHD_OPTION_HTTPS_PRIORITIES, 0, (void *)(uintptr_t)TLS_PRIORITIES },
        { MHD_OPTION_END, 0, NULL },
    }, none[] = { { MHD_OPTION_END, 0, NULL } };
    return MHD_start_daemon(flags | (secure ? MHD_USE_TLS : 0), 0, NULL, NULL, on_request, sv,
                            MHD_OPTION_EXTERNAL_LOGGER, log_library, NULL,
                            MHD_OPTION_LISTEN_SOCKET, l->fd,
                            MHD_OPTION_THREAD_POOL_SIZE, (unsigned)POOL,
                            MHD_OPTION_CONNECTION_LIMIT, (unsigned)sv->config->connections + SPARE,
                            MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)sv->config->idle_timeout,
                            MHD_OPTION_STRICT_FOR_CLIENT, 1,
                            MHD_OPTION_NOTIFY_CONNECTION, on_connection, &h->door[number],
                            MHD_OPTION_NOTIFY_COMPLETED, on_completed, sv,
                            MHD_OPTION_URI_LOG_CALLBACK, on_request_line, sv,
                            MHD_OPTION_ARRAY, secure ? tls : none,
                            MHD_OPTION_END);
}

struct http *http_open(struct service *sv, char *why, size_t size)
{
    struct http *h = calloc(1, sizeof *h);
    if (!h)
        return NULL;
    h->service = sv;
    sv->route_names = route_names;
    if (front_start(turn_away, sv, why, size) && tls_open(sv->config, why, size) && listen_open(sv->config, &h->listeners, why, size)) {
        sv->listeners = &h->listeners;
        return h;
    }
    listen_close(&h->listeners);
    tls_close();
    free(h);
    return NULL;
}

bool http_start(struct http *h, char *why, size_t size)
{
    conns_limit(h->service->conns, &h->service->config->connections, &h->service->config->address_connections);
    for (int i = 0; i < h->listeners.count; i++) {
        const struct listening *l = &h->listeners.at[i];
        size_t used = strlen(h->url);
        h->door[i] = (struct door){ h->service, i };
        snprintf(h->url + used, sizeof h->url - used, "%s%s", used ? ", " : "", l->url);
        if (!(h->daemon[i] = start_daemon(h, i))) {
            snprintf(why, size, "the HTTP library did not start");
            return false;
        }
    }
    h->ticks = ticker_start(&h->ticker, h->service);
    if (!h->ticks)
        snprintf(why, size, "no thread can be started");
    return h->ticks;
}

struct listeners *http_listeners(struct http *h)
{
    return &h->listeners;
}

void http_renew(struct http *h)
{
    atomic_store(&h->ticker.renew, true);
}

const char *http_url(const struct http *h)
{
    return h->url;
}

/* Takes no connection any more; the socket is ours again, and open. */
static void quiesce(struct http *h)
{
    for (int i = 0; i < h->listeners.count && !h->quiet; i++)
        if (h->daemon[i])
            h->listeners.at[i].fd = MHD_quiesce_daemon(h->daemon[i]);
    h->quiet = true;
}

void http_leave(struct http *h)
{
    struct service *sv = h->service;
    quiesce(h);
    jobs_leave_waiters(sv->jobs);
    int empty = 0;
    for (int waited = 0; empty < LEAVE_SURE && waited < STOP_MS; waited += LEAVE_LOOK_MS) {
        usleep(1000 * LEAVE_LOOK_MS);
        empty = conns_count(sv->conns) ? 0 : empty + 1;      /* one may have been taken just before */
        if (waited >= LEAVE_REST_MS)
            conns_cut_resting(sv->conns);
    }
}

void http_stop(struct http *h)
{
    struct service *sv = h->service;
    quiesce(h);
    for (int waited = 0; atomic_load(&sv->exchanges) > 0 && waited < STOP_MS; waited += 10) {
        if (waited == CUT_MS)
            conns_reap(sv->conns, sga_now(), 1);
        usleep(10000);
    }
    if (h->ticks)
        ticker_stop(&h->ticker);
    for (int i = 0; i < h->listeners.count; i++)
        if (h->daemon[i])
            MHD_stop_daemon(h->daemon[i]);
    sv->listeners = NULL;
    listen_close(&h->listeners);
    tls_close();
    free(h);
}
