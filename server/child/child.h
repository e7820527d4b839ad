/* The child process that runs the algebra for one worker, and how a worker starts and
 * ends it. The algebra may run out of memory inside GMP or FLINT, which ends the process:
 * then one job has failed, and nothing else. */
#ifndef SERVER_CHILD_H
#define SERVER_CHILD_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

struct config;

#define CHILD_FLAG "--run-child"      /* hidden first argument of the program */

/* Roles: the name that a process list shows. All can do the same. */
#define CHILD_JOB "sgad-job"
#define CHILD_CHECK "sgad-check"

enum { CHILD_SAID = 256 };

struct child {
    pid_t pid;       /* 0: none */
    int fd;          /* our end of the socket */
    int said_fd;     /* what it writes to standard error; -1: that is the service's own */
    char said[CHILD_SAID];   /* of one that has ended: its last words there, in one line */
};

/* Start one, with an empty environment and nothing of the service's but its socket and a pipe for
 * standard error. Its death signal is tied to the calling thread, which must outlive it. */
bool child_start(struct child *c, const char *role, const struct config *config);
/* Whether it is there, and idle: a child says nothing by itself but its end. */
bool child_lives(const struct child *c);
/* Whether its starter has no more use for it: asked while it is waited for. */
struct child_patience {
    bool (*over)(void *ctx);
    void *ctx;
};
/* Starts one in place of the one that is there, or of none, and waits until it says that it has
 * confined itself. False with the reason in why, and none is there. */
bool child_renew(struct child *c, const char *role, const struct config *config, struct child_patience patience, char *why, size_t size);
/* Kill and reap; how it ended (or had ended) in words, and as waitpid has it. Nothing (0) where there is none. */
int child_end(struct child *c, char *how, size_t size);

/* The child's main: serves requests on descriptor 3 until it is closed. */
int child_main(int argc, char **argv);

#endif
