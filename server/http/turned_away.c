/* The reply says what every problem says. The connection ends after it: where the next request would begin is not known. */
#include "turned_away.h"
#include "budget.h"
#include "conns.h"
#include "log.h"
#include "metrics.h"
#include "peer.h"
#include "problem.h"
#include "routes.h"
#include "service.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "error.h"

enum { LINGER_SECONDS = 2 };      /* for a client that is still writing to take in the reply */

void request_name(struct service *sv, char *out, size_t size)
{
    snprintf(out, size, "%08x-%lx", sv->request_prefix, atomic_fetch_add(&sv->request_number, 1));
}

static void note(struct service *sv, int fd, const struct sga_error *err, const char *id)
{
    struct sockaddr_storage a = { 0 };
    socklen_t length = sizeof a;
    char peer[PEER_TEXT], status[16];
    const char *who = getpeername(fd, (struct sockaddr *)&a, &length) == 0 ? peer_text((struct sockaddr *)&a, peer) : NULL;
    metrics_refused(sv->metrics, err->code);
    metrics_http(sv->metrics, route_number(NULL), "", sga_code_status(err->code));
    snprintf(status, sizeof status, "%d", sga_code_status(err->code));
    log_event(LOG_L_INFO, "request", "request_id", id, "route", route_names[route_number(NULL)], "peer", who, "#status", status,
              "code", sga_code_text(err->code), "reason", err->detail, NULL);
}

static const char *reason(int status)
{
    return status == 414 ? "URI Too Long" : status == 431 ? "Request Header Fields Too Large" : status == 505 ? "HTTP Version Not Supported" : "Bad Request";
}

size_t turn_away(void *cls, struct conn *conn, int fd, bool head_request, const struct sga_error *err, char reply[FRONT_REPLY])
{
    struct service *sv = cls;
    char id[32], date[64];
    int status = sga_code_status(err->code);
    time_t now = time(NULL);
    struct tm tm;
    char *text = problem_text(err);
    request_name(sv, id, sizeof id);
    strftime(date, sizeof date, "%a, %d %b %Y %H:%M:%S GMT", gmtime_r(&now, &tm));
    int n = snprintf(reply, FRONT_REPLY, "HTTP/1.1 %d %s\r\nDate: %s\r\nConnection: close\r\nContent-Type: application/problem+json\r\n"
                     "X-Request-Id: %s\r\nX-Content-Type-Options: nosniff\r\nContent-Length: %zu\r\n\r\n%s", status, reason(status), date, id,
                     text ? strlen(text) : 0, text && !head_request ? text : "");
    free(text);
    note(sv, fd, err, id);
    conn_deadline(conn, sga_now() + LINGER_SECONDS);
    return n > 0 && n < FRONT_REPLY ? (size_t)n : 0;
}
