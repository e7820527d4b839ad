/* Child processes that make a part of one job beside the child that runs it: the pieces of its loop, a sweep's sets (lib/base/team.h).
 *
 * There are as many as workers have nothing to do, and each ends once a worker wants its place. Pieces are handed out a few at a time; those of
 * a helper that is lost are handed out again. What a helper made waits here until the leader asks for its next pieces. */
#ifndef SERVER_HELPERS_H
#define SERVER_HELPERS_H

#include <stdbool.h>
#include <stddef.h>

struct config;
struct helpers;
struct job;
struct jobs;
struct metrics;
struct pollfd;
struct wire_share;

/* Of a job that begins to run: none yet. request is borrowed. NULL when memory ends: then there is
 * no help, which the functions below bear. */
struct helpers *helpers_new(const struct config *c, struct jobs *js, struct metrics *m, const struct job *job, const char *request, size_t length);
/* Ends them. NULL is allowed. */
void helpers_free(struct helpers *h);

/* The leader asks, and is told by fd whether there is help from now on. Starts processes, waits for none. False: the leader is gone. */
bool helpers_share(struct helpers *h, const struct wire_share *share, int fd);
/* Whether the leader was told that there is help: only then may it ask for pieces. */
bool helpers_shares(const struct helpers *h);
/* The leader asks for its next pieces: it gets what is made, and its pieces, at once or by helpers_look, once there are some or all is made.
 * False: the leader is gone. */
bool helpers_next(struct helpers *h, int fd);

/* Fills fds[0 .. most) with what is to be polled for; returns how many. */
int helpers_poll(const struct helpers *h, struct pollfd *fds, int most);
/* After a poll: takes what has come. False: the leader is gone. */
bool helpers_look(struct helpers *h, int fd);

#endif
