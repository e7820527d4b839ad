/* What clients ask for in headers: how long to wait, and which format. */
#ifndef SERVER_PREFER_H
#define SERVER_PREFER_H

#include <stdbool.h>
#include <stddef.h>

/* Seconds of `wait=N` in a Prefer header (RFC 7240); -1 where it has none; 0 for
 * respond-async. header may be NULL. */
long prefer_wait(const char *header);

/* Which of the offered media types an Accept header likes best: its index; the first one
 * offered wins a tie and a missing header. -1: none is acceptable. */
int prefer_type(const char *accept, const char *const *offered, int count);

/* Does an Accept-Encoding header take gzip, and not rather have the body as it is (RFC 9110, 12.5.3)? header may be NULL. */
bool prefer_gzip(const char *header);

#endif
