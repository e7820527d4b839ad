/* The listening socket. */
#ifndef SERVER_LISTEN_H
#define SERVER_LISTEN_H

#include <stddef.h>

/* A socket bound to HOST:PORT, which must be a loopback address; its port in *port. -1 with
 * the reason in why. */
int listen_open(const char *address, int *port, char *why, size_t size);
/* HOST of HOST:PORT as it stands in a URL. */
void listen_host(const char *address, char *out, size_t size);

#endif
