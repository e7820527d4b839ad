/* A daemon over HTTP, by libcurl: http, https or a UNIX socket, by a proxy where the environment names one. */
#ifndef CLIENTS_HTTP_CLIENT_H
#define CLIENTS_HTTP_CLIENT_H

#include <stdbool.h>
#include <stddef.h>

#include "buf.h"

struct http_server {
    char url[1024];           /* before each path: http[s]://HOST[:PORT][/PREFIX], no slash at its end */
    char name[300];           /* in messages: "HOST port PORT", or the socket's path */
    char socket[108];         /* path of a UNIX socket; "" otherwise */
    const char *token;        /* shown as a bearer token; NULL: none */
    const char *ca;           /* file of the certificates that are trusted (PEM); NULL: the system's */
    bool here;                /* on this machine: no proxy, and a token may go without encryption */
    bool tls;
};

struct http_reply {
    int status;
    char location[256];       /* "" where there is none */
    struct sga_buf body;
};

/* Takes http[s]://HOST[:PORT][/PREFIX] or unix:PATH apart, the token from SGA_TOKEN and the trusted
 * certificates from SGA_CA; false where it is something else. */
bool http_parse(const char *url, struct http_server *server);
/* Sends method and path, with a JSON body unless it is NULL, and `Prefer: wait=` seconds. Over TLS it goes on only with a server whose
 * certificate names the host and leads to one that is trusted. An interrupt (interrupt.h) ends it, unless it has a body.
 * False with a reason in why. The body is the caller's to free. */
bool http_ask(const struct http_server *server, const char *method, const char *path, const char *body, size_t length,
              int wait, struct http_reply *reply, char *why, size_t size);
/* GETs a path that is sent line by line and gives each to `line`, without its end, as it comes, until that returns false (true is returned
 * then) or the reply ends. Where the status is not 200, the whole reply instead. False with a reason: no reply, or it broke off. */
bool http_lines(const struct http_server *server, const char *path, bool (*line)(void *ctx, const char *text), void *ctx,
                struct http_reply *reply, char *why, size_t size);

#endif
