/* Requests that are refused before the HTTP library has seen them. */
#ifndef SERVER_TURNED_AWAY_H
#define SERVER_TURNED_AWAY_H

#include "front.h"

struct service;

/* An id for a request that has none of its own that could be used. */
void request_name(struct service *sv, char *out, size_t size);
/* Of the kind front_refuse; cls: the service. One head, one problem, counted and logged as any refusal. */
size_t turn_away(void *cls, struct conn *conn, int fd, bool head_request, const struct sga_error *err, char reply[FRONT_REPLY]);

#endif
