/* Measuring is one pread of /proc/self/statm (a microsecond), done once for each
 * LOOK_EVERY bytes asked for, and before each larger piece. */
#include "watch.h"

#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <flint/flint.h>
#include <gmp.h>

#include "budget.h"
#include "error.h"
#include "mem.h"

enum { LOOK_EVERY = 1 << 20, PACE = 1 << 13 };      /* bytes asked for; what is counted: some 10 ms of the dearest */
/* How far past a limit the wall stands: what asks its budget comes to an end before. */
static const double GRACE_SECONDS = 0.5, GRACE_PART = 0.25;
static const size_t GRACE_BYTES = 32 << 20;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { FIELD = 2 };      /* resident: sanitizers map terabytes */
#else
enum { FIELD = 6 };      /* data: private and writable */
#endif

static int statm = -1;   /* written by sga_watch_init only */

static _Thread_local struct {
    const struct sga_budget *budget;      /* NULL: no watch */
    sga_wall *wall;
    void *ctx;
    size_t asked;        /* since the last look */
    long paced;          /* counted since the last look at the clock */
    size_t base, needed;
    bool over, ending;
    long count[SGA_COUNTERS];
} watch;

static _Thread_local bool refused;

static size_t measure(void)
{
    char text[128];
    ssize_t n = statm < 0 ? -1 : pread(statm, text, sizeof text - 1, 0);
    if (n <= 0)
        return 0;
    text[n] = 0;
    char *at = text;
    unsigned long pages = 0;
    for (int i = 0; i < FIELD; i++)
        pages = strtoul(at, &at, 10);
    return pages * (size_t)sysconf(_SC_PAGESIZE);
}

static double megabytes(size_t bytes)
{
    return (double)bytes / (1 << 20);
}

static void memory_error(struct sga_error *err)
{
    sga_fail(err, SGA_E_LIMIT_MEMORY, "the limit of %.0f MB was reached: %.0f MB were needed; "
             "raise limits.megabytes or ask for less in want", megabytes(watch.budget->max_memory), megabytes(watch.needed));
}

static void call_wall(const struct sga_error *err)
{
    if (!watch.wall || watch.ending)
        return;
    watch.ending = true;
    watch.wall(watch.ctx, err);
}

/* Far past the deadline: what asks its budget came to an end before. */
static void look_late(void)
{
    struct sga_error err = { 0 };
    watch.paced = 0;
    if (!(watch.budget->deadline > 0) || sga_now() <= watch.budget->deadline + GRACE_SECONDS)
        return;
    sga_budget_ok(watch.budget, &err);
    call_wall(&err);
}

static void look(size_t size)
{
    struct sga_error err = { 0 };
    size_t used = sga_watch_used(), most = watch.budget->max_memory, grace = (size_t)(GRACE_PART * (double)most);
    size_t needed = size > SIZE_MAX - used ? SIZE_MAX : used + (size > LOOK_EVERY ? size : 0);
    watch.asked = 0;
    if (most && needed > most) {
        watch.over = true;
        watch.needed = needed > watch.needed ? needed : watch.needed;
    }
    if (most && needed > most && needed - most > (grace > GRACE_BYTES ? grace : GRACE_BYTES)) {
        memory_error(&err);
        call_wall(&err);
    }
    look_late();
}

void sga_watch_ask(size_t size)
{
    if (!watch.budget)
        return;
    if (watch.asked + size < LOOK_EVERY)
        watch.asked += size;
    else
        look(size);
}

void sga_watch_failed(size_t size)
{
    struct sga_error err = { 0 };
    if (watch.budget) {
        sga_fail(&err, SGA_E_LIMIT_MEMORY, "no memory is left for %.1f MB more: %.0f MB were in use; ask for less in want",
                 megabytes(size), megabytes(sga_watch_used()));
        call_wall(&err);
    }
    fputs("sga: out of memory\n", stderr);
    abort();
}

void sga_watch_refuse(void)
{
    refused = true;
}

bool sga_watch_refused(void)
{
    bool was = refused;
    refused = false;
    return was;
}

void sga_watch_begin(const struct sga_budget *budget, sga_wall *wall, void *ctx)
{
    memset(&watch, 0, sizeof watch);
    watch.wall = wall;
    watch.ctx = ctx;
    watch.base = measure();
    watch.budget = budget;
}

void sga_watch_end(void)
{
    memset(&watch, 0, sizeof watch);
}

size_t sga_watch_used(void)
{
    if (!watch.budget)
        return 0;
    size_t now = measure();
    return now > watch.base ? now - watch.base : 0;
}

bool sga_watch_memory_ok(struct sga_error *err)
{
    if (!watch.over)
        return true;
    memory_error(err);
    return false;
}

bool sga_watch_ok(void)
{
    return sga_budget_ok(watch.budget, NULL);
}

void sga_watch_count(enum sga_counter what, long more)
{
    watch.count[what] += more;
    if (watch.budget && (watch.paced += more) >= PACE)
        look_late();
}

long sga_watch_counted(enum sga_counter what)
{
    return watch.count[what];
}

/* GMP tells sizes that we do not need. */
static void *gmp_realloc(void *p, size_t before, size_t size)
{
    (void)before;
    return sga_realloc(p, size);
}

static void gmp_free(void *p, size_t size)
{
    (void)size;
    free(p);
}

void sga_watch_init(void)
{
    if (statm < 0)
        statm = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
}

void sga_watch_hook(void)
{
    mp_set_memory_functions(sga_malloc, gmp_realloc, gmp_free);
    __flint_set_memory_functions(sga_malloc, sga_calloc, sga_realloc, free);
}
