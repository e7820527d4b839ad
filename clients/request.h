/* A solved request, wherever it was solved: here in the process, or by a daemon. */
#ifndef CLIENTS_REQUEST_H
#define CLIENTS_REQUEST_H

#include <stdbool.h>
#include <stddef.h>

#include "buf.h"

struct answer {
    struct sga_buf text;      /* the result; or the problem object; or nothing */
    char problem[1400];       /* why there is none, for a reader; "" otherwise */
};

/* Runs the request in this process. */
bool solve_here(const char *request, size_t length, struct answer *a);
/* Posts it to http://HOST[:PORT] and waits, at most so many seconds (0: as long as it takes). */
bool solve_there(const char *url, const char *request, size_t length, double seconds, struct answer *a);

#endif
