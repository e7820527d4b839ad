#include "budget.h"
#include "error.h"
#include "watch.h"

#include <time.h>

static double clock_seconds(clockid_t id)
{
    struct timespec ts;
    clock_gettime(id, &ts);
    return (double)ts.tv_sec + 1e-9 * (double)ts.tv_nsec;
}

double sga_now(void) { return clock_seconds(CLOCK_MONOTONIC); }
double sga_cpu(void) { return clock_seconds(CLOCK_THREAD_CPUTIME_ID); }

bool sga_budget_ok(const struct sga_budget *b, struct sga_error *err)
{
    if (!b)
        return true;
    if (b->cancelled && b->cancelled(b->cancel_ctx))
        return sga_fail(err, SGA_E_CANCELLED, "the job was cancelled");
    double late = b->deadline > 0 ? sga_now() - b->deadline : 0;
    if (late > 0)
        return sga_fail(err, SGA_E_LIMIT_SECONDS,
                        "the limit of %g seconds was reached (%.1f had passed); raise limits.seconds or ask for less in want",
                        b->seconds, b->seconds + late);
    if (b->cpu_deadline > 0 && sga_cpu() > b->cpu_deadline)
        return sga_fail(err, SGA_E_LIMIT_SECONDS, "the %g seconds of CPU of this part were used up; raise limits.seconds or ask for less in want", b->seconds);
    return sga_watch_memory_ok(err);
}
