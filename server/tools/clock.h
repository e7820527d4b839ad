/* Wall-clock time as users see it: RFC 3339, UTC, milliseconds. */
#ifndef SERVER_CLOCK_H
#define SERVER_CLOCK_H

#include <stdint.h>

enum { CLOCK_TEXT = 32 };

/* Milliseconds since 1970, UTC. */
int64_t clock_ms(void);
/* The same, but not before `earlier`: the clock may have been put back since. */
int64_t clock_after(int64_t earlier);
/* "2024-05-06T07:08:09.012Z" into out[CLOCK_TEXT]. */
void clock_text(char *out, int64_t ms);

#endif
