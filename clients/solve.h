/* A solved request, wherever it was solved: here in the process, or by a daemon. */
#ifndef CLIENTS_SOLVE_H
#define CLIENTS_SOLVE_H

#include <stdbool.h>
#include <stddef.h>

#include "buf.h"

struct answer {
    struct sga_buf text;      /* the result; or the problem object; or nothing */
    char problem[1400];       /* why there is none, for a reader; "" otherwise */
    bool readable;            /* shown as text, not as JSON */
    bool interpret_only;      /* no machine code is made */
    int processes;            /* that may make it, at most; 0: one */
    bool interrupted;         /* by Ctrl-C, and its job was withdrawn */
};

/* Runs the request in this process. Where a library call runs past memory or time and cannot
 * be left, `stuck` is called with the problem in a: it ends the process. */
bool solve_here(const char *request, size_t length, struct answer *a, void (*stuck)(const struct answer *a));
/* Posts it to a daemon's address (http_client.h) and waits, at most so many seconds (0: as long as it takes). Ctrl-C cancels the job
 * that was posted. */
bool solve_there(const char *url, const char *request, size_t length, double seconds, struct answer *a);

#endif
