/* Another process of the program that now stands where this one's did, with the same arguments and this one's listening sockets. */
#ifndef SERVER_SUCCESSOR_H
#define SERVER_SUCCESSOR_H

#include <stddef.h>
#include <sys/types.h>

struct listeners;

/* Starts it and waits until it has read its settings and listens (inherit.h). Its process id; 0 with the reason in why: then it is
 * gone, and nothing has changed. From then on the names of UNIX sockets are its to remove. */
pid_t successor_start(struct listeners *ls, char **argv, char *why, size_t size);

#endif
