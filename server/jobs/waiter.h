/* Who waits for a job: a place in its list (jobs.h), which the one who waits owns. */
#ifndef SERVER_WAITER_H
#define SERVER_WAITER_H

#include <stdbool.h>
#include <stdint.h>

struct account;
struct job;

enum wait_kind { WAIT_STORED, WAIT_ENDED, WAIT_EVENT };

struct waiter {
    void *connection;
    struct account *account;
    enum wait_kind kind;
    uint64_t seen;            /* WAIT_EVENT: the event known already */
    double deadline;          /* sga_now() */
    bool waiting;
    bool left;                /* resumed since its client hung up: it waits no more */
    struct job *job;
    struct waiter *prev, *next, *all_prev, *all_next;
};

#endif
