/* Threads that read and check requests, so that no reading keeps an HTTP thread, with all its
 * connections, from the others: a short text can mean a second of work. */
#ifndef SERVER_CHECK_THREADS_H
#define SERVER_CHECK_THREADS_H

#include <stdbool.h>

struct check_threads;
struct exchange;

enum { CHECK_THREADS_INLINE = 1024 };      /* bodies up to so many bytes are checked where they are */

/* NULL where threads or memory are missing. */
struct check_threads *check_threads_new(void);
/* Suspends the connection, checks e->body into e->check, and resumes it, once. False: closed,
 * or as many wait already as may; then nothing has happened. */
bool check_threads_submit(struct check_threads *cs, struct exchange *e);
/* Those that wait are resumed unchecked, those at work end their check; no more are taken. */
void check_threads_close(struct check_threads *cs);
void check_threads_free(struct check_threads *cs);           /* closed before; NULL is allowed */

#endif
