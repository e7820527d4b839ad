/* HTTP by hand: the reply is read to its end, then taken apart. */
#include "http.h"

#include <errno.h>
#include <netdb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

enum { PATIENCE = 60 };      /* seconds of silence past the wait that was asked for */

bool http_parse(const char *url, struct http_server *server)
{
    const char *token = getenv("SGA_TOKEN");
    *server = (struct http_server){ .token = token && *token && !strpbrk(token, "\r\n") ? token : NULL };
    if (strncmp(url, "unix:/", 6) == 0 && strlen(url + 5) < sizeof server->path) {
        strcpy(server->path, url + 5);
        strcpy(server->host, "localhost");
        strcpy(server->port, "80");
        return true;
    }
    if (strncasecmp(url, "http://", 7) != 0)
        return false;
    const char *host = url + 7;
    bool bracket = *host == '[';
    host += bracket;
    size_t n = strcspn(host, bracket ? "]" : ":/");
    if (n == 0 || n >= sizeof server->host || (bracket && host[n] != ']'))
        return false;
    memcpy(server->host, host, n);
    server->host[n] = 0;
    const char *rest = host + n + bracket;
    strcpy(server->port, "80");
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

static void be_patient(int fd, int patience)
{
    struct timeval limit = { .tv_sec = patience };
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
}

static int dial_unix(const char *path, int patience, char *why, size_t size)
{
    struct sockaddr_un a = { .sun_family = AF_UNIX };
    strcpy(a.sun_path, path);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (struct sockaddr *)&a, sizeof a) == 0) {
        be_patient(fd, patience);
        return fd;
    }
    snprintf(why, size, "cannot connect to %s: %s", path, strerror(errno));
    if (fd >= 0)
        close(fd);
    return -1;
}

static int dial(const struct http_server *server, int patience, char *why, size_t size)
{
    struct addrinfo hints = { .ai_socktype = SOCK_STREAM }, *list;
    int rc = getaddrinfo(server->host, server->port, &hints, &list), fd = -1;
    if (rc != 0) {
        snprintf(why, size, "cannot find %s: %s", server->host, gai_strerror(rc));
        return -1;
    }
    for (struct addrinfo *ai = list; ai && fd < 0; ai = ai->ai_next) {
        fd = socket(ai->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
        be_patient(fd, patience);
        if (fd >= 0 && connect(fd, ai->ai_addr, ai->ai_addrlen) != 0) {
            snprintf(why, size, "cannot connect to %s port %s: %s", server->host, server->port, strerror(errno));
            close(fd);
            fd = -1;
        }
    }
    freeaddrinfo(list);
    return fd;
}

/* False once the other side takes no more; it may still have said why. */
static bool send_all(int fd, const char *data, size_t length)
{
    while (length) {
        ssize_t n = send(fd, data, length, MSG_NOSIGNAL);
        if (n <= 0)
            return false;
        data += n;
        length -= (size_t)n;
    }
    return true;
}

static bool receive_all(int fd, struct sga_buf *in)
{
    char piece[16384];
    for (;;) {
        ssize_t n = recv(fd, piece, sizeof piece, 0);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return in->len > 0 && (n == 0 || errno == ECONNRESET);
        sga_buf_put(in, piece, (size_t)n);
    }
}

/* The value of a header in the head that ends at `end`, into out. */
static bool header(const char *head, const char *end, const char *name, char *out, size_t size)
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

static bool take_apart(const struct sga_buf *in, struct http_reply *reply)
{
    char value[64];
    const char *end = strstr(in->data, "\r\n\r\n"), *all = in->data + in->len;
    if (strncmp(in->data, "HTTP/1.", 7) != 0 || !end)
        return false;
    end += 2;
    reply->status = atoi(in->data + 9);
    header(in->data, end, "Location", reply->location, sizeof reply->location);
    if (header(in->data, end, "Retry-After", value, sizeof value))
        reply->retry_after = atof(value);
    const char *body = end + 2;
    if (header(in->data, end, "Transfer-Encoding", value, sizeof value) && strcasecmp(value, "chunked") == 0)
        return unchunk(body, all, &reply->body);
    if (header(in->data, end, "Content-Length", value, sizeof value) && strtoul(value, NULL, 10) != (size_t)(all - body))
        return false;
    sga_buf_put(&reply->body, body, (size_t)(all - body));
    return true;
}

bool http_ask(const struct http_server *server, const char *method, const char *path, const char *body, size_t length,
              int wait, struct http_reply *reply, char *why, size_t size)
{
    struct sga_buf out = { 0 }, in = { 0 };
    bool colon = strchr(server->host, ':');
    *reply = (struct http_reply){ 0 };
    int fd = *server->path ? dial_unix(server->path, wait + PATIENCE, why, size) : dial(server, wait + PATIENCE, why, size);
    if (fd < 0)
        return false;
    sga_buf_printf(&out, "%s %s HTTP/1.1\r\nHost: %s%s%s:%s\r\nConnection: close\r\nAccept: application/json\r\nPrefer: wait=%d\r\n",
                   method, path, colon ? "[" : "", server->host, colon ? "]" : "", server->port, wait);
    if (server->token)
        sga_buf_printf(&out, "Authorization: Bearer %s\r\n", server->token);
    if (body)
        sga_buf_printf(&out, "Content-Type: application/json\r\nContent-Length: %zu\r\n", length);
    sga_buf_puts(&out, "\r\n");
    if (send_all(fd, out.data, out.len) && body)
        send_all(fd, body, length);
    bool ok = receive_all(fd, &in) && take_apart(&in, reply);
    if (!ok)
        snprintf(why, size, "%s port %s gave no whole reply", server->host, server->port);
    close(fd);
    sga_buf_free(&out);
    sga_buf_free(&in);
    return ok;
}
