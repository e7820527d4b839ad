/* The thread that keeps the time: deadlines of those who wait and of connections, the tokens' file,
 * the certificate's. It is also who tells a supervisor that the service lives: a sign of life means that
 * it got the locks which every request and every job takes, on jobs, on the queue and on connections. */
#ifndef SERVER_TICKER_H
#define SERVER_TICKER_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

struct ticker {
    struct service *service;
    pthread_t thread;
    double alive_at;                 /* when the supervisor is to be told next; of the thread */
    atomic_bool stop, renew;         /* renew: the certificate is to be read anew, soon */
};

/* False: no thread can be started. */
bool ticker_start(struct ticker *t, struct service *sv);
void ticker_stop(struct ticker *t);

#endif
