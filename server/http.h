/* The HTTP library, started and stopped. */
#ifndef SERVER_HTTP_H
#define SERVER_HTTP_H

#include <stdbool.h>
#include <stddef.h>

#include "service.h"

struct http;

/* Binds config->listen and starts to answer. The port taken is in *port. */
struct http *http_start(struct service *sv, int *port, char *why, size_t size);
/* Stops to accept connections, waits for the requests under way (a few seconds, then they
 * are cut), and stops. Nobody may be suspended by then: waiters have been closed. */
void http_stop(struct http *h);
/* "[::1]" or "127.0.0.1" as it stands in a URL, into out. */
void http_host(const struct config *c, char *out, size_t size);

#endif
