/* The listening sockets: addresses, UNIX sockets, or one that systemd passes. */
#ifndef SERVER_LISTEN_H
#define SERVER_LISTEN_H

#include <stdbool.h>
#include <stddef.h>

struct config;

enum { LISTEN_MOST = 8 };

struct listening {
    int fd;                /* -1: closed, or somebody else's to close */
    bool local;            /* a UNIX socket: never TLS */
    char address[320];     /* as config->listen has it */
    char url[320];         /* what to tell users: https://127.0.0.1:8443, unix:/run/sgad/socket */
    char host[264];        /* as it stands in a URL, or "": a name that this socket answers to */
    char path[108];        /* of a UNIX socket that was made here, else "" */
};

struct listeners {
    struct listening at[LISTEN_MOST];
    int count;
};

/* Opens what config->listen names, with commas between. Off loopback it insists on TLS and
 * tokens, or on the switches that give each of them up. False with the reason in why; what was
 * opened is to be closed then too. */
bool listen_open(const struct config *c, struct listeners *out, char *why, size_t size);
/* Closes descriptors that are open and removes the names of UNIX sockets. */
void listen_close(struct listeners *ls);

#endif
