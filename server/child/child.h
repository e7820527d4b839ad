/* The child process that runs the algebra for one worker, and how a worker starts and
 * ends it. The algebra may run out of memory inside GMP or FLINT, which ends the process:
 * then one job has failed, and nothing else. */
#ifndef SERVER_CHILD_H
#define SERVER_CHILD_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "config.h"

#define CHILD_FLAG "--run-child"      /* hidden first argument of the program */

struct child {
    pid_t pid;       /* 0: none */
    int fd;          /* our end of the socket */
};

/* Start one. Its death signal is tied to the calling thread, which must outlive it. */
bool child_start(struct child *c, const struct config *config);
/* Kill and reap; how it ended (or had ended) in words. */
void child_end(struct child *c, char *how, size_t size);

/* The child's main: serves requests on descriptor 3 until it is closed. */
int child_main(int argc, char **argv);

#endif
