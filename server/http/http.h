/* The HTTP library, started and stopped. */
#ifndef SERVER_HTTP_H
#define SERVER_HTTP_H

#include <stdbool.h>
#include <stddef.h>

struct http;
struct service;

/* Opens what config->listen names, and reads the certificate: connections may come and wait. NULL with the reason in why. */
struct http *http_open(struct service *sv, char *why, size_t size);
/* Starts to answer. False with the reason in why; http_stop follows in any case. */
bool http_start(struct http *h, char *why, size_t size);
struct listeners *http_listeners(struct http *h);
/* A successor takes connections from now on, as soon as it can. Those that are here are answered, and kept alive no longer: back
 * once none is left, or after a few seconds. Who waits for a job is told where it is by then. */
void http_leave(struct http *h);
/* Stops to accept connections, waits for the requests under way (a few seconds, then they
 * are cut), and stops. Nobody may be suspended by then: waiters have been closed. */
void http_stop(struct http *h);
/* Reads the certificate anew, soon. */
void http_renew(struct http *h);
/* Where it listens, for people. */
const char *http_url(const struct http *h);

#endif
