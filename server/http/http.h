/* The HTTP library, started and stopped. */
#ifndef SERVER_HTTP_H
#define SERVER_HTTP_H

#include <stdbool.h>
#include <stddef.h>

#include "service.h"

struct http;

/* Opens what config->listen names and starts to answer. NULL with the reason in why. */
struct http *http_start(struct service *sv, char *why, size_t size);
/* Stops to accept connections, waits for the requests under way (a few seconds, then they
 * are cut), and stops. Nobody may be suspended by then: waiters have been closed. */
void http_stop(struct http *h);
/* Where it listens, for people. */
/* Reads the certificate anew, soon. */
void http_renew(struct http *h);
const char *http_url(const struct http *h);

#endif
