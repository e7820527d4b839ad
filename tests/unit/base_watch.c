/* Limits of memory and time: what asks is told, what cannot ask meets the wall; GMP's and
 * FLINT's own allocations count. The wall is left by longjmp here, as a program would leave
 * by ending. */
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <flint/fmpz.h>

#include "budget.h"
#include "check.h"
#include "error.h"
#include "mem.h"
#include "watch.h"

#define MB ((size_t)1 << 20)

static jmp_buf away;
static struct sga_error last;

static void wall(void *ctx, const struct sga_error *err)
{
    (void)ctx;
    last = *err;
    sga_watch_end();
    longjmp(away, 1);
}

/* Touched, so that it counts however memory is measured. */
static char *take(size_t size)
{
    char *p = sga_malloc(size);
    memset(p, 1, size);
    sga_watch_ask(MB);
    return p;
}

static void asked(void)
{
    struct sga_budget b = { .max_memory = 64 * MB };
    struct sga_error err = { 0 };
    sga_watch_begin(&b, wall, NULL);
    char *one = take(40 * MB);
    CHECK(sga_budget_ok(&b, &err), "40 of 64 MB: %s", err.detail);
    CHECK(sga_watch_used() >= 40 * MB && sga_watch_used() < 60 * MB, "%zu", sga_watch_used());
    char *two = take(30 * MB);
    CHECK(!sga_budget_ok(&b, &err) && err.code == SGA_E_LIMIT_MEMORY, "70 of 64 MB");
    CHECK(strstr(err.detail, "64 MB") && strstr(err.detail, "limits.megabytes"), "%s", err.detail);
    free(one);
    free(two);
    sga_watch_begin(&b, wall, NULL);
    err = (struct sga_error){ 0 };
    CHECK(sga_budget_ok(&b, &err), "another job is not guilty: %s", err.detail);
    sga_watch_end();
    CHECK(sga_watch_used() == 0 && sga_watch_memory_ok(&err), "no watch");
}

static void at_the_wall(void)
{
    struct sga_budget b = { .max_memory = 64 * MB };
    last = (struct sga_error){ 0 };
    if (!setjmp(away)) {
        sga_watch_begin(&b, wall, NULL);
        free(sga_malloc(1000 * MB));       /* never touched: refused by its size alone */
        CHECK(false, "no wall");
    }
    CHECK(last.code == SGA_E_LIMIT_MEMORY && strstr(last.detail, "64 MB") && strstr(last.detail, "100"), "%s", last.detail);
    last = (struct sga_error){ 0 };
    if (!setjmp(away)) {
        sga_watch_begin(&b, wall, NULL);
        free(sga_calloc((size_t)1 << 40, (size_t)1 << 40));
        CHECK(false, "no wall");
    }
    CHECK(last.code == SGA_E_LIMIT_MEMORY, "a product of sizes past all memory");
}

/* GMP in one call: 2^(2^33) has a gigabyte. */
static void inside_a_library(void)
{
    struct sga_budget b = { .max_memory = 64 * MB };
    fmpz_t x;
    fmpz_init(x);
    last = (struct sga_error){ 0 };
    if (!setjmp(away)) {
        sga_watch_begin(&b, wall, NULL);
        fmpz_set_ui(x, 3);
        fmpz_pow_ui(x, x, (ulong)1 << 33);
        CHECK(false, "no wall");
    }
    CHECK(last.code == SGA_E_LIMIT_MEMORY, "one power: %s", last.detail);
}

static bool stop(void *ctx)
{
    return ++*(int *)ctx > 2;
}

/* What loops without a budget are told. */
static void asked_from_below(void)
{
    int asks = 0;
    struct sga_budget b = { .cancelled = stop, .cancel_ctx = &asks }, late = { .deadline = sga_now() - 1, .seconds = 1 };
    CHECK(sga_watch_ok());
    sga_watch_begin(&b, NULL, NULL);
    CHECK(sga_watch_ok() && sga_watch_ok() && !sga_watch_ok() && asks == 3);
    sga_watch_begin(&late, NULL, NULL);
    CHECK(!sga_watch_ok());
    sga_watch_end();
    CHECK(sga_watch_ok());
}

/* Past the deadline inside a call that allocates and asks nothing. */
static void past_the_deadline(void)
{
    struct sga_budget b = { .deadline = sga_now() - 100, .seconds = 5 };
    struct sga_error err = { 0 };
    last = err;
    if (!setjmp(away)) {
        sga_watch_begin(&b, wall, NULL);
        for (int i = 0; i < 64; i++)
            free(sga_malloc(MB / 8));
        CHECK(false, "no wall");
    }
    CHECK(last.code == SGA_E_LIMIT_SECONDS && strstr(last.detail, "5 seconds") && strstr(last.detail, "105."), "%s", last.detail);
    last = err;
    if (!setjmp(away)) {                   /* and in loops that allocate nothing */
        sga_watch_begin(&b, wall, NULL);
        for (int i = 0; i < 64; i++)
            sga_watch_count(SGA_COUNT_BALLS, 1000);
        CHECK(false, "no wall");
    }
    CHECK(last.code == SGA_E_LIMIT_SECONDS, "%s", last.detail);
    b.deadline = sga_now() + 100;
    sga_watch_begin(&b, wall, NULL);
    for (int i = 0; i < 64; i++)
        sga_watch_count(SGA_COUNT_BALLS, 1000);
    CHECK(sga_watch_counted(SGA_COUNT_BALLS) == 64000, "in time");
    sga_watch_end();
}

int main(void)
{
    sga_watch_init();
    sga_watch_hook();
    asked();
    at_the_wall();
    inside_a_library();
    asked_from_below();
    past_the_deadline();
    return CHECK_END();
}
