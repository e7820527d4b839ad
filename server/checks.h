/* Threads that read and check requests, so that no reading keeps an HTTP thread, with all its
 * connections, from the others: a short text can mean a second of work. */
#ifndef SERVER_CHECKS_H
#define SERVER_CHECKS_H

#include <stdbool.h>

struct checks;
struct exchange;

enum { CHECKS_INLINE = 1024 };      /* bodies up to so many bytes are checked where they are */

/* NULL where threads or memory are missing. */
struct checks *checks_new(void);
/* Suspends the connection, checks e->body into e->check, and resumes it, once. False: closed,
 * or as many wait already as may; then nothing has happened. */
bool checks_submit(struct checks *cs, struct exchange *e);
/* Those that wait are resumed unchecked, those at work end their check; no more are taken. */
void checks_close(struct checks *cs);
void checks_free(struct checks *cs);           /* closed before; NULL is allowed */

#endif
