/* The commands about requests and jobs that solve nothing here. */
#ifndef CLIENTS_JOBS_RUN_H
#define CLIENTS_JOBS_RUN_H

#include <stddef.h>

#include "arguments.h"

/* check: reads the request and says all that is wrong with it, here or by a daemon. DONE: nothing is. */
int check_run(const struct arguments *args, const char *request, size_t length);
/* list, get, wait, cancel, events, ready. */
int jobs_run(const struct arguments *args);

#endif
