/* Pages for machine code: written, then read-only and executable. */
#define _GNU_SOURCE    /* MAP_ANONYMOUS, MAP_NORESERVE */
#include "exec.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "mem.h"

enum { PAGE = 4096 };

struct sga_exec {
    unsigned char *mapped;     /* all that was reserved, and how much */
    size_t reserved;
    unsigned char *base;
    size_t bytes;
    bool refused;              /* pages cannot be made executable here */
    int pages;
    int *length;               /* by page: pages of the piece that begins here, or 0 */
};

#if defined(__x86_64__) && defined(__linux__)
enum { SUPPORTED = 1 };
#else
enum { SUPPORTED = 0 };
#endif

struct sga_exec *sga_exec_new(size_t bytes)
{
    size_t size = PAGE;
    while (size < bytes && size < SIZE_MAX / 8)
        size *= 2;
    if (!SUPPORTED)
        return NULL;
    /* size bytes at a multiple of size */
    unsigned char *at = mmap(NULL, 2 * size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (at == MAP_FAILED)
        return NULL;
    struct sga_exec *m = sga_calloc(1, sizeof *m);
    m->mapped = at;
    m->reserved = 2 * size;
    m->base = at + (size - (uintptr_t)at % size) % size;
    m->bytes = size;
    m->pages = (int)(size / PAGE);
    assert((uintptr_t)m->base % size == 0 && m->base + size <= m->mapped + m->reserved);
    m->length = sga_calloc((size_t)m->pages, sizeof *m->length);
    return m;
}

void sga_exec_free(struct sga_exec *m)
{
    if (!m)
        return;
    munmap(m->mapped, m->reserved);
    free(m->length);
    free(m);
}

void sga_exec_range(const struct sga_exec *m, void **base, size_t *bytes)
{
    *base = m->base;
    *bytes = m->bytes;
}

/* The first of so many pages in a row that are free, or -1. */
static int find_room(const struct sga_exec *m, int pages)
{
    for (int from = 0, i; from + pages <= m->pages; from = i + m->length[i]) {
        for (i = from; i < from + pages && !m->length[i];)
            i++;
        if (i == from + pages)
            return from;
    }
    return -1;
}

/* One page after the other: a filter that sees the address and the length of a call, and not their sum, can then tell to the byte
 * what becomes executable. */
static bool make_executable(unsigned char *at, int pages)
{
    for (int i = 0; i < pages; i++)
        if (mprotect(at + (size_t)i * PAGE, PAGE, PROT_READ | PROT_EXEC) != 0)
            return false;
    return true;
}

const void *sga_exec_add(struct sga_exec *m, const void *code, size_t bytes)
{
    if (m->refused || bytes == 0 || bytes > m->bytes)
        return NULL;
    int pages = (int)((bytes + PAGE - 1) / PAGE), first = find_room(m, pages);
    if (first < 0)
        return NULL;
    unsigned char *at = m->base + (size_t)first * PAGE;
    size_t size = (size_t)pages * PAGE;
    if (mprotect(at, size, PROT_READ | PROT_WRITE) != 0)
        return NULL;
    memcpy(at, code, bytes);
    memset(at + bytes, 0xCC, size - bytes);     /* what is not code traps */
    if (!make_executable(at, pages)) {
        m->refused = true;
        return NULL;
    }
    m->length[first] = pages;
    return at;
}

void sga_exec_drop(struct sga_exec *m, const void *at)
{
    size_t page = (size_t)((const unsigned char *)at - m->base) / PAGE;
    assert(page < (size_t)m->pages && m->length[page] > 0);
    m->length[page] = 0;
}
