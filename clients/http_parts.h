/* Parts of an exchange, for those who read a reply while it comes. */
#ifndef CLIENTS_HTTP_PARTS_H
#define CLIENTS_HTTP_PARTS_H

#include "http_client.h"
#include "stream.h"

/* Connects and sends the request; false with a reason in why. The caller closes the stream. */
bool http_send(const struct http_server *server, const char *method, const char *path, const char *body, size_t length, int wait,
               struct stream *stream, char *why, size_t size);
/* Appends all that still comes. */
bool http_receive_all(struct stream *stream, struct sga_buf *in);
/* A whole reply: status, headers, body. False: it is none. */
bool http_take_apart(const struct sga_buf *in, struct http_reply *reply);
/* The value of a header in the head of a reply, up to end. */
bool http_header(const char *head, const char *end, const char *name, char *out, size_t size);

#endif
