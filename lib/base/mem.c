#include "mem.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *check(void *p, size_t size)
{
    if (!p && size) {
        fputs("sga: out of memory\n", stderr);
        abort();
    }
    return p;
}

void *sga_malloc(size_t size)
{
    return check(malloc(size ? size : 1), size);
}

void *sga_calloc(size_t count, size_t size)
{
    return check(calloc(count ? count : 1, size ? size : 1), size);
}

void *sga_realloc(void *p, size_t size)
{
    return check(realloc(p, size ? size : 1), size);
}

char *sga_strdup(const char *s)
{
    size_t n = strlen(s) + 1;
    return memcpy(sga_malloc(n), s, n);
}
