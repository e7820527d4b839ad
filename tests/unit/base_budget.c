/* Two clocks: what is granted on either ends the work, and CPU of a part is not used up by waiting. */
#include <string.h>
#include <time.h>

#include "budget.h"
#include "check.h"
#include "error.h"

static void spend(double seconds)
{
    double end = sga_cpu() + seconds;
    while (sga_cpu() < end)
        ;
}

static void cpu_ends(void)
{
    struct sga_error err = { 0 };
    struct sga_budget b = { .cpu_deadline = sga_cpu() + 0.02, .seconds = 0.02 };
    struct timespec nap = { .tv_nsec = 60000000 };
    CHECK(sga_budget_ok(&b, &err));
    nanosleep(&nap, NULL);
    CHECK(sga_budget_ok(&b, &err));
    spend(0.03);
    CHECK(!sga_budget_ok(&b, &err) && err.code == SGA_E_LIMIT_SECONDS && strstr(err.detail, "CPU"));
}

static void clock_ends(void)
{
    struct sga_error err = { 0 };
    struct sga_budget b = { .deadline = sga_now() - 1, .cpu_deadline = sga_cpu() + 100, .seconds = 1 };
    CHECK(!sga_budget_ok(&b, &err) && err.code == SGA_E_LIMIT_SECONDS);
    CHECK(sga_budget_ok(&(struct sga_budget){ 0 }, &err));
}

int main(void)
{
    cpu_ends();
    clock_ends();
    return CHECK_END();
}
