/* HTTP by hand: the reply is read to its end, then taken apart. */
#include "http_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { PATIENCE = 60 };      /* seconds of silence past the wait that was asked for */

bool http_parse(const char *url, struct http_server *server)
{
    const char *token = getenv("SGA_TOKEN"), *ca = getenv("SGA_CA");
    *server = (struct http_server){ .token = token && *token && !strpbrk(token, "\r\n") ? token : NULL, .ca = ca && *ca ? ca : NULL };
    if (strncmp(url, "unix:/", 6) == 0 && strlen(url + 5) < sizeof server->path) {
        strcpy(server->path, url + 5);
        strcpy(server->host, "localhost");
        strcpy(server->port, "80");
        return true;
    }
    server->tls = strncasecmp(url, "https://", 8) == 0;
    if (!server->tls && strncasecmp(url, "http://", 7) != 0)
        return false;
    const char *host = url + (server->tls ? 8 : 7);
    bool bracket = *host == '[';
    host += bracket;
    size_t n = strcspn(host, bracket ? "]" : ":/");
    if (n == 0 || n >= sizeof server->host || (bracket && host[n] != ']'))
        return false;
    memcpy(server->host, host, n);
    server->host[n] = 0;
    const char *rest = host + n + bracket;
    strcpy(server->port, server->tls ? "443" : "80");
    if (*rest == ':') {
        size_t digits = strspn(++rest, "0123456789");
        if (digits == 0 || digits > 5)
            return false;
        memcpy(server->port, rest, digits);
        server->port[digits] = 0;
        rest += digits;
    }
    return *rest == 0 || strcmp(rest, "/") == 0;
}

bool http_receive_all(struct stream *stream, struct sga_buf *in)
{
    char piece[16384];
    ssize_t n;
    while ((n = stream_receive(stream, piece, sizeof piece)) > 0)
        sga_buf_put(in, piece, (size_t)n);
    return n == 0 && in->len > 0;
}

bool http_header(const char *head, const char *end, const char *name, char *out, size_t size)
{
    size_t n = strlen(name);
    for (const char *line = head; line < end; line = strstr(line, "\r\n") + 2) {
        if (strncasecmp(line, name, n) != 0 || line[n] != ':')
            continue;
        const char *value = line + n + 1 + strspn(line + n + 1, " \t");
        snprintf(out, size, "%.*s", (int)strcspn(value, "\r\n"), value);
        return true;
    }
    return false;
}

static bool unchunk(const char *s, const char *end, struct sga_buf *out)
{
    while (s < end) {
        char *after;
        unsigned long n = strtoul(s, &after, 16);
        const char *data = strstr(after, "\r\n");
        if (after == s || !data || n > (size_t)(end - data) - 2)
            return false;
        if (n == 0)
            return true;
        sga_buf_put(out, data + 2, n);
        s = data + 2 + n + 2;
    }
    return false;
}

bool http_take_apart(const struct sga_buf *in, struct http_reply *reply)
{
    char value[64];
    const char *end = strstr(in->data, "\r\n\r\n"), *all = in->data + in->len;
    if (strncmp(in->data, "HTTP/1.", 7) != 0 || !end)
        return false;
    end += 2;
    reply->status = atoi(in->data + 9);
    http_header(in->data, end, "Location", reply->location, sizeof reply->location);
    if (http_header(in->data, end, "Retry-After", value, sizeof value))
        reply->retry_after = atof(value);
    const char *body = end + 2;
    if (http_header(in->data, end, "Transfer-Encoding", value, sizeof value) && strcasecmp(value, "chunked") == 0)
        return unchunk(body, all, &reply->body);
    if (http_header(in->data, end, "Content-Length", value, sizeof value) && strtoul(value, NULL, 10) != (size_t)(all - body))
        return false;
    sga_buf_put(&reply->body, body, (size_t)(all - body));
    return true;
}

/* Off this machine a token goes over TLS only. */
static bool may_show_token(const struct http_server *server)
{
    return server->tls || *server->path || strcasecmp(server->host, "localhost") == 0 || strncmp(server->host, "127.", 4) == 0
        || strcmp(server->host, "::1") == 0;
}

bool http_send(const struct http_server *server, const char *method, const char *path, const char *body, size_t length, int wait,
               struct stream *stream, char *why, size_t size)
{
    struct sga_buf out = { 0 };
    bool colon = strchr(server->host, ':');
    if (server->token && !may_show_token(server)) {
        snprintf(why, size, "a token is not sent to %s without encryption; use https://, or unset SGA_TOKEN", server->host);
        return false;
    }
    if (!stream_open(stream, server, wait + PATIENCE, why, size))
        return false;
    sga_buf_printf(&out, "%s %s HTTP/1.1\r\nHost: %s%s%s:%s\r\nConnection: close\r\nAccept: application/json\r\nPrefer: wait=%d\r\n",
                   method, path, colon ? "[" : "", server->host, colon ? "]" : "", server->port, wait);
    if (server->token)
        sga_buf_printf(&out, "Authorization: Bearer %s\r\n", server->token);
    if (body)
        sga_buf_printf(&out, "Content-Type: application/json\r\nContent-Length: %zu\r\n", length);
    sga_buf_puts(&out, "\r\n");
    if (stream_send(stream, out.data, out.len) && body)
        stream_send(stream, body, length);
    sga_buf_free(&out);
    return true;
}

bool http_ask(const struct http_server *server, const char *method, const char *path, const char *body, size_t length,
              int wait, struct http_reply *reply, char *why, size_t size)
{
    struct sga_buf in = { 0 };
    struct stream stream;
    *reply = (struct http_reply){ 0 };
    if (!http_send(server, method, path, body, length, wait, &stream, why, size))
        return false;
    bool ok = http_receive_all(&stream, &in) && http_take_apart(&in, reply);
    if (!ok)
        snprintf(why, size, "%s port %s gave no whole reply", server->host, server->port);
    stream_close(&stream);
    sga_buf_free(&in);
    return ok;
}
