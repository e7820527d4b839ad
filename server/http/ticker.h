/* The thread that keeps the time: deadlines of those who wait and of connections, the tokens' file,
 * the certificate's. */
#ifndef SERVER_TICKER_H
#define SERVER_TICKER_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

#include "service.h"

struct ticker {
    struct service *service;
    pthread_t thread;
    atomic_bool stop, renew;         /* renew: the certificate is to be read anew, soon */
};

/* False: no thread can be started. */
bool ticker_start(struct ticker *t, struct service *sv);
void ticker_stop(struct ticker *t);

#endif
