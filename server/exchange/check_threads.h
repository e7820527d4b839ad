/* Threads that have requests read and checked, each by a child process in its sandbox: a short
 * text can mean a second of work, and its exact arithmetic can end a process. No HTTP thread
 * reads a request, so none is kept from its other connections. */
#ifndef SERVER_CHECK_THREADS_H
#define SERVER_CHECK_THREADS_H

#include <stdbool.h>

struct check_threads;
struct exchange;
struct service;

/* Starts threads and children with the settings of the service. NULL where threads or memory are missing. */
struct check_threads *check_threads_new(struct service *sv);
/* Suspends the connection, has e->body checked into e->check, and resumes it, once. Accounts
 * take turns, and each pays for its seconds. False: closed, or as many wait already as may, in
 * all or of this account; then nothing has happened. */
bool check_threads_submit(struct check_threads *cs, struct exchange *e);
/* Those that wait or are at work are resumed unchecked; no more are taken. */
void check_threads_close(struct check_threads *cs);
void check_threads_free(struct check_threads *cs);           /* closed before; NULL is allowed */

#endif
