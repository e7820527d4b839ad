/* sga top: the live picture of a daemon. */
#ifndef CLIENTS_TOP_H
#define CLIENTS_TOP_H

#include <stdbool.h>

/* Shows the metrics of the daemon at this address every so many seconds until interrupted;
 * once: a single time. The program's exit status. */
int top_run(const char *url, double seconds, bool once);

#endif
