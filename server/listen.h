/* The listening socket: an address, a UNIX socket, or one that systemd passes. */
#ifndef SERVER_LISTEN_H
#define SERVER_LISTEN_H

#include <stddef.h>

#include "config.h"

struct listening {
    int fd;
    char url[320];         /* what to tell users: https://127.0.0.1:8443, unix:/run/sgad/socket */
    char host[264];        /* as it stands in a URL, or "": a name that this socket answers to */
    char path[108];        /* of a UNIX socket that was made here, else "" */
};

/* Opens what config->listen names. Off loopback it insists on TLS and tokens, or on the
 * switches that give each of them up. False with the reason in why. */
bool listen_open(const struct config *c, struct listening *out, char *why, size_t size);
/* Removes the UNIX socket's name; the descriptor is the caller's. */
void listen_forget(const struct listening *l);

#endif
