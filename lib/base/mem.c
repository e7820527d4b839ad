#define _GNU_SOURCE    /* mremap */
#include "mem.h"
#include "watch.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

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

static const size_t OWN_PAGES = 1 << 20;

void *sga_zero_pages(size_t size)
{
    if (size < OWN_PAGES)
        return sga_calloc(size, 1);
    sga_watch_ask(size);
    void *p = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (p == MAP_FAILED)
        sga_watch_failed(size);
    return p;
}

void sga_zero_pages_free(void *p, size_t size)
{
    if (!p || size < OWN_PAGES)
        free(p);
    else
        munmap(p, size);
}

void *sga_zero_pages_grow(void *p, size_t old, size_t size)
{
    if (old >= OWN_PAGES) {
        sga_watch_ask(size - old);
        p = mremap(p, old, size, MREMAP_MAYMOVE);
        if (p == MAP_FAILED)
            sga_watch_failed(size - old);
        return p;
    }
    void *to = sga_zero_pages(size);
    if (old)
        memcpy(to, p, old);
    sga_zero_pages_free(p, old);
    return to;
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
