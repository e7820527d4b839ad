/* On whose account jobs run: what each token may hold at one time, and its own place in the
 * queue. Guarded by the lock of the jobs table, but for what is fixed. */
#ifndef SERVER_QUOTA_H
#define SERVER_QUOTA_H

#include <stdbool.h>

enum { ACCOUNT_NAME = 64 };

/* 0: no limit but the service's own. */
struct quota {
    long jobs;            /* that wait or run */
    long bytes;           /* of the requests that wait */
    long waiters;         /* requests that wait for a job, and event streams */
    long seconds;         /* of running, in one hour */
};

struct job;

struct account {
    char name[ACCOUNT_NAME];         /* of the token, "" where none is needed; fixed */
    struct quota quota;
    unsigned long alive, bytes, waiting;
    double hour, used;               /* start of the hour that is counted; seconds run in it */
    double reserved;                 /* that its jobs which have not ended may still run */
    unsigned long running;
    unsigned long accepted, refused;     /* jobs, since the start */
    double ran;                      /* seconds of running, since the start */
    struct job *front, *back;        /* its queue */
    struct account *ring_next, *ring_prev;   /* those whose queue is not empty */
    struct account *next;            /* all */
    unsigned long checked;           /* its last turn among requests that are checked; of their lock */
};

enum { ACCOUNT_HOUR = 3600 };

/* Which quota a further job of so many bytes, which may run for so long, would break, in words;
 * NULL: none. Seconds are reserved until the job has ended, so that the hour's quota holds
 * however many jobs wait; alone, a job may run also where its limit is above the quota.
 * *retry gets the seconds after which it is worth trying again. */
const char *quota_full(struct account *a, unsigned long bytes, double seconds, double now, long *retry);
/* A job of the account ran for so long. */
void quota_ran(struct account *a, double seconds, double now);
bool quota_may_wait(const struct account *a);

#endif
