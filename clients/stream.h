/* A connection to a server as a stream of bytes: TCP, TLS over TCP, or a UNIX socket. */
#ifndef CLIENTS_STREAM_H
#define CLIENTS_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "http_client.h"

struct stream {
    int fd;
    struct tls_session *tls;     /* NULL: none */
};

/* Connects; over TLS it goes on only with a server whose certificate names the host and leads
 * to one that is trusted. patience: seconds of silence that are borne. False with a reason. */
bool stream_open(struct stream *s, const struct http_server *server, int patience, char *why, size_t size);
/* False once the other side takes no more; it may still have said why. */
bool stream_send(struct stream *s, const char *data, size_t length);
/* As recv: 0 at the end, negative on failure, and where an interrupt ends the wait (interrupt.h). */
ssize_t stream_receive(struct stream *s, char *data, size_t size);
void stream_close(struct stream *s);

#endif
