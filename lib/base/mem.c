#include "mem.h"
#include "watch.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void *sga_malloc(size_t size)
{
    sga_watch_ask(size);
    void *p = malloc(size ? size : 1);
    if (!p)
        sga_watch_failed(size);
    return p;
}

void *sga_calloc(size_t count, size_t size)
{
    size_t all = count && size > SIZE_MAX / count ? SIZE_MAX : count * size;
    sga_watch_ask(all);
    void *p = calloc(count ? count : 1, size ? size : 1);
    if (!p)
        sga_watch_failed(all);
    return p;
}

void *sga_realloc(void *p, size_t size)
{
    sga_watch_ask(size);
    p = realloc(p, size ? size : 1);
    if (!p)
        sga_watch_failed(size);
    return p;
}

void *sga_try_malloc(size_t size)
{
    sga_watch_ask(size);
    void *p = malloc(size ? size : 1);
    if (!p)
        sga_watch_refuse();
    return p;
}

char *sga_strdup(const char *s)
{
    size_t n = strlen(s) + 1;
    return memcpy(sga_malloc(n), s, n);
}
