/* A reply that comes over minutes: chunks are taken apart as they come. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "http_parts.h"

/* Longer lines are no events of a daemon's. */
enum { MOST_LINE = 1 << 20 };

struct reader {
    bool chunked;
    size_t left;              /* bytes of the present chunk */
    bool over;                /* the last chunk has come */
    struct sga_buf size, text;/* of the chunk's head; the line so far */
    bool (*line)(void *ctx, const char *text);
    void *ctx;
};

/* False: the caller has enough, or the line is too long. */
static bool take_text(struct reader *r, char c)
{
    if (c != '\n') {
        sga_buf_put(&r->text, &c, 1);
        return r->text.len < MOST_LINE;
    }
    bool more = r->line(r->ctx, r->text.len ? r->text.data : "");
    sga_buf_clear(&r->text);
    return more;
}

/* A head of a chunk ends with its line; an empty line is the end of the chunk before. */
static void take_size(struct reader *r, char c)
{
    if (c != '\n') {
        sga_buf_put(&r->size, &c, 1);
        return;
    }
    bool digits = r->size.len && *r->size.data != '\r';
    r->left = digits ? strtoul(r->size.data, NULL, 16) : 0;
    r->over = digits && r->left == 0;
    sga_buf_clear(&r->size);
}

static bool take(struct reader *r, const char *s, size_t n)
{
    for (size_t i = 0; i < n && !r->over; i++) {
        if (r->chunked && r->left == 0) {
            take_size(r, s[i]);
            continue;
        }
        r->left -= r->chunked;
        if (!take_text(r, s[i]))
            return false;
    }
    return true;
}

/* The head, and what came with it; NULL: none came. */
static const char *read_head(struct stream *stream, struct sga_buf *in)
{
    char piece[4096];
    const char *end = NULL;
    ssize_t n;
    while (!end && (n = stream_receive(stream, piece, sizeof piece)) > 0) {
        sga_buf_put(in, piece, (size_t)n);
        end = strstr(in->data, "\r\n\r\n");
    }
    return end && strncmp(in->data, "HTTP/1.", 7) == 0 ? end + 2 : NULL;
}

static bool read_lines(struct stream *stream, const struct sga_buf *in, const char *end, struct reader *r)
{
    char value[64], piece[4096];
    ssize_t n = 1;
    r->chunked = http_header(in->data, end, "Transfer-Encoding", value, sizeof value) && strcasecmp(value, "chunked") == 0;
    bool more = take(r, end + 2, (size_t)(in->data + in->len - end - 2));
    while (more && !r->over && (n = stream_receive(stream, piece, sizeof piece)) > 0)
        more = take(r, piece, (size_t)n);
    return !more || r->over || (n == 0 && !r->chunked);
}

bool http_lines(const struct http_server *server, const char *path, bool (*line)(void *ctx, const char *text), void *ctx,
                struct http_reply *reply, char *why, size_t size)
{
    struct sga_buf in = { 0 };
    struct stream stream;
    struct reader r = { .line = line, .ctx = ctx };
    *reply = (struct http_reply){ 0 };
    if (!http_send(server, "GET", path, NULL, 0, 0, &stream, why, size))
        return false;
    const char *end = read_head(&stream, &in);
    reply->status = end ? atoi(in.data + 9) : 0;
    bool ok = !end ? false : reply->status == 200 ? read_lines(&stream, &in, end, &r) : http_receive_all(&stream, &in) && http_take_apart(&in, reply);
    if (!ok)
        snprintf(why, size, "%s port %s gave no whole reply", server->host, server->port);
    stream_close(&stream);
    sga_buf_free(&in);
    sga_buf_free(&r.size);
    sga_buf_free(&r.text);
    return ok;
}
