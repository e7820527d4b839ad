/* Quotas. The seconds are counted in hours that begin with the first job of each. */
#include "quota.h"

#include <stddef.h>

static void turn_hour(struct account *a, double now)
{
    if (a->hour > 0 && now - a->hour < ACCOUNT_HOUR)    /* 0: none has begun, however young the machine's clock is */
        return;
    a->hour = now;
    a->used = 0;
}

const char *quota_full(struct account *a, unsigned long bytes, double seconds, double now, long *retry)
{
    const struct quota *q = &a->quota;
    *retry = 5;
    if (q->jobs && a->alive >= (unsigned long)q->jobs)
        return "jobs that wait or run";
    if (q->bytes && a->bytes + bytes > (unsigned long)q->bytes)
        return "bytes of requests that wait";
    turn_hour(a, now);
    double taken = a->used + a->reserved;
    if (q->seconds && (a->used >= (double)q->seconds || (taken > 0 && taken + seconds > (double)q->seconds))) {
        if (a->used > 0)
            *retry = (long)(a->hour + ACCOUNT_HOUR - now) + 1;
        return "seconds of running in an hour, those that its waiting jobs may need included";
    }
    return NULL;
}

void quota_ran(struct account *a, double seconds, double now)
{
    turn_hour(a, now);
    a->used += seconds;
    a->ran += seconds;
}

bool quota_may_wait(const struct account *a)
{
    return !a->quota.waiters || a->waiting < (unsigned long)a->quota.waiters;
}
