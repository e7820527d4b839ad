/* A small HTTP/1.1 client: one request on one connection, over TCP, TLS or a UNIX socket. */
#ifndef CLIENTS_HTTP_CLIENT_H
#define CLIENTS_HTTP_CLIENT_H

#include <stdbool.h>
#include <stddef.h>

#include "buf.h"

struct http_server {
    char host[256];
    char port[8];
    char path[108];           /* of a UNIX socket; "" otherwise */
    const char *token;        /* shown as a bearer token; NULL: none */
    bool tls;
    const char *ca;           /* file of the certificates that are trusted (PEM); NULL: the system's */
};

struct http_reply {
    int status;
    char location[256];       /* "" where there is none */
    double retry_after;       /* seconds; 0 where there is none */
    struct sga_buf body;
};

/* Takes http[s]://HOST[:PORT][/] or unix:PATH apart, the token from SGA_TOKEN and the trusted
 * certificates from SGA_CA; false where it is something else. */
bool http_parse(const char *url, struct http_server *server);
/* Sends method and path, with a JSON body unless it is NULL, and `Prefer: wait=` seconds.
 * False with a reason in why. The body is the caller's to free. */
bool http_ask(const struct http_server *server, const char *method, const char *path, const char *body, size_t length,
              int wait, struct http_reply *reply, char *why, size_t size);
/* GETs a path that is sent line by line and gives each to `line`, without its end, as it comes, until that returns false (true is returned
 * then) or the reply ends. Where the status is not 200, the whole reply instead. False with a reason: no reply, or it broke off. */
bool http_lines(const struct http_server *server, const char *path, bool (*line)(void *ctx, const char *text), void *ctx,
                struct http_reply *reply, char *why, size_t size);

#endif
