/* Admission. What is ambiguous by its bytes alone the front has refused (net/front.h); what
 * follows holds without it too. The HTTP library takes the first of two Content-Lengths, prefers chunked over
 * Content-Length, accepts `Content-Length : 5` as some other header, takes a line `: x` for the
 * end of the head, and cuts a path at %00: each lets a proxy in front see other requests than
 * we do (request smuggling).
 *
 * The library does not show the line `: x`, but it leaves names and values where they came in:
 * between them lie just `: ` and CR LF in what clients commonly send. A request with anything
 * else between is answered, and is the last one of its connection. */
#include "admission.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "config.h"
#include "error.h"
#include "listen.h"
#include "service.h"

struct seen {
    int host, length, coding, origins;
    const char *host_value, *coding_value, *origin;
    const char *end;             /* of the header before */
    bool bad_name, odd;
};

static enum MHD_Result look(void *cls, enum MHD_ValueKind kind, const char *name, const char *value)
{
    struct seen *s = cls;
    (void)kind;
    if (!*name)
        s->bad_name = true;
    if (!value || value != name + strlen(name) + 2 || (s->end && name != s->end + 2))
        s->odd = true;
    s->end = value ? value + strlen(value) : NULL;
    for (const char *c = name; *c; c++)
        if (*c <= ' ' || *c >= 0x7f || strchr("()<>@,;:\\\"/[]?={}", *c))
            s->bad_name = true;
    if (strcasecmp(name, "Host") == 0) {
        s->host++;
        s->host_value = value;
    } else if (strcasecmp(name, "Content-Length") == 0) {
        s->length++;
    } else if (strcasecmp(name, "Transfer-Encoding") == 0) {
        s->coding++;
        s->coding_value = value;
    } else if (strcasecmp(name, "Origin") == 0) {
        s->origins++;
        s->origin = value;
    }
    return MHD_YES;
}

/* Is this the name of a host that is served? A rebound DNS name is not. */
static bool known_host(const struct service *sv, const char *name, size_t length)
{
    static const char *const own[] = { "localhost", "127.0.0.1", "[::1]" };
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (strlen(own[i]) == length && strncasecmp(own[i], name, length) == 0)
            return true;
    for (int i = 0; sv->listeners && i < sv->listeners->count; i++) {
        const char *host = sv->listeners->at[i].host;
        if (length && strlen(host) == length && strncasecmp(host, name, length) == 0)
            return true;
    }
    for (const char *p = sv->config->allow_host; p && *p;) {
        p += strspn(p, ", ");
        size_t n = strcspn(p, ", ");
        if (n && n == length && strncasecmp(p, name, n) == 0)
            return true;
        p += n;
    }
    return false;
}

/* NAME or NAME:PORT */
static bool known_authority(const struct service *sv, const char *text)
{
    size_t n = *text == '[' ? strcspn(text, "]") + 1 : strcspn(text, ":");
    if (n > strlen(text))
        return false;
    const char *port = text + n;
    size_t digits = *port == ':' ? strspn(port + 1, "0123456789") : 0;
    if (*port == ':' && (digits != strlen(port + 1) || digits > 5 || atoi(port + 1) > 65535))
        return false;
    return (*port == 0 || *port == ':') && known_host(sv, text, n);
}

static bool known_origin(const struct service *sv, const char *origin)
{
    if (strncasecmp(origin, "http://", 7) == 0)
        return known_authority(sv, origin + 7);
    return strncasecmp(origin, "https://", 8) == 0 && known_authority(sv, origin + 8);
}

/* Is there just CR LF CR LF after the last header? begin: of the request's first line. */
static bool ends_plainly(struct exchange *e, const struct seen *s, const char *begin)
{
    const union MHD_ConnectionInfo *size = MHD_get_connection_info(e->connection, MHD_CONNECTION_INFO_REQUEST_HEADER_SIZE);
    return s->end && size && s->end + 4 == begin + size->header_size;
}

bool admit(struct exchange *e, const char *begin, struct sga_error *err)
{
    struct seen s = { .host = 0 };
    MHD_get_connection_values(e->connection, MHD_HEADER_KIND, look, &s);
    e->last = s.odd || !ends_plainly(e, &s, begin);
    if (e->bad_path)
        return sga_fail(err, SGA_E_BAD_REQUEST, "The path holds a zero byte.");
    if (s.bad_name)
        return sga_fail(err, SGA_E_BAD_REQUEST, "A header name holds a character that is not allowed, such as a blank before the colon.");
    if (s.host != 1)
        return sga_fail(err, SGA_E_BAD_REQUEST, s.host ? "There is more than one Host header." : "The Host header is missing.");
    if (s.length > 1)
        return sga_fail(err, SGA_E_BAD_REQUEST, "There is more than one Content-Length header.");
    if (s.length && s.coding)
        return sga_fail(err, SGA_E_BAD_REQUEST, "Content-Length and Transfer-Encoding exclude each other.");
    if (s.coding > 1 || (s.coding && strcasecmp(s.coding_value, "chunked") != 0))
        return sga_fail(err, SGA_E_BAD_REQUEST, "The only transfer encoding known is chunked.");
    if (!s.host_value || !known_authority(e->service, s.host_value))
        return sga_fail(err, SGA_E_FORBIDDEN_HOST, "The Host header names a host that is not served. Names are added with --allow-host.");
    if (s.origins > 1)
        return sga_fail(err, SGA_E_BAD_REQUEST, "There is more than one Origin header.");
    if (s.origin && !known_origin(e->service, s.origin))
        return sga_fail(err, SGA_E_FORBIDDEN_HOST, "Pages of this origin may not use the service.");
    return true;
}

struct parameters {
    const char *known;           /* names, separated by blanks */
    const char *unknown, *twice;
    unsigned long seen;          /* bit set, by place in known */
};

/* The place of the name in the list; -1. */
static int place(const char *known, const char *name)
{
    size_t n = strlen(name);
    int at = 0;
    for (const char *p = known; *p; at++) {
        size_t k = strcspn(p, " ");
        if (k == n && memcmp(p, name, n) == 0)
            return at;
        p += k + (p[k] == ' ');
    }
    return -1;
}

static enum MHD_Result parameter(void *cls, enum MHD_ValueKind kind, const char *name, const char *value)
{
    struct parameters *p = cls;
    (void)kind;
    (void)value;
    int at = place(p->known, name);
    if (at < 0)
        p->unknown = name;
    else if (p->seen & 1ul << at)
        p->twice = name;
    else
        p->seen |= 1ul << at;
    return MHD_YES;
}

bool admit_query(struct exchange *e, const char *known, struct sga_error *err)
{
    struct parameters p = { .known = known };
    MHD_get_connection_values(e->connection, MHD_GET_ARGUMENT_KIND, parameter, &p);
    if (p.unknown && !*known)
        return sga_fail(err, SGA_E_BAD_REQUEST, "This path takes no query, such as `%.60s`.", p.unknown);
    if (p.unknown)
        return sga_fail(err, SGA_E_BAD_REQUEST, "The query has the parameter `%.60s`; this path knows only: %s.", p.unknown, known);
    return !p.twice || sga_fail(err, SGA_E_BAD_REQUEST, "The query has the parameter `%.60s` twice.", p.twice);
}

/* Bodies are JSON in UTF-8, as they are. */
static bool plain_body(struct exchange *e, const char *type, struct sga_error *err)
{
    const char *coding = exchange_header(e, "Content-Encoding"), *charset = strchr(type, ';');
    if (coding && strcasecmp(coding, "identity") != 0)
        return sga_fail(err, SGA_E_MEDIA_TYPE, "The Content-Encoding `%.60s` is not known: a request is sent as it is.", coding);
    if (!charset)
        return true;
    charset += 1 + strspn(charset + 1, " \t");
    bool utf8 = strcasecmp(charset, "charset=utf-8") == 0 || strcasecmp(charset, "charset=\"utf-8\"") == 0 || !*charset;
    return utf8 || sga_fail(err, SGA_E_MEDIA_TYPE, "A request is sent in UTF-8: `%.60s` is not known.", charset);
}

bool admit_body(struct exchange *e, struct sga_error *err)
{
    const char *type = exchange_header(e, "Content-Type"), *length = exchange_header(e, "Content-Length");
    size_t n = type ? strcspn(type, "; \t") : 0;
    if (n != 16 || strncasecmp(type, "application/json", 16) != 0)
        return sga_fail(err, SGA_E_MEDIA_TYPE, "A request is sent with Content-Type: application/json.");
    if (!plain_body(e, type, err))
        return false;
    if (length && strtoull(length, NULL, 10) > (unsigned long long)e->service->config->body_limit)
        return sga_fail(err, SGA_E_BODY_TOO_LARGE, "The body may have at most %ld bytes.", atomic_load(&e->service->config->body_limit));
    return true;
}

bool admit_drop(struct exchange *e)
{
    const char *length = exchange_header(e, "Content-Length");
    unsigned long long most = ADMIT_DROP_FACTOR * (unsigned long long)e->service->config->body_limit;
    return !exchange_header(e, "Expect") && (!length || strtoull(length, NULL, 10) <= most);
}
