/* Pages for machine code: written, then read-only and executable. */
#define _GNU_SOURCE    /* MAP_ANONYMOUS, MAP_NORESERVE */
#include "exec.h"

#include <assert.h>
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
    long made, found;          /* pieces that were added, new and known */
    int pages;
    struct piece {
        int pages, users;      /* 0 pages: none begins here; 0 users: kept for who makes the same again, until its room is wanted */
        uint64_t hash;
        size_t bytes;
        void *key;             /* of sga_exec_name, owned; or NULL */
        size_t key_bytes;
        uint64_t key_hash;
    } *piece;                  /* by page */
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
    m->piece = sga_calloc((size_t)m->pages, sizeof *m->piece);
    return m;
}

void sga_exec_free(struct sga_exec *m)
{
    if (!m)
        return;
    munmap(m->mapped, m->reserved);
    for (int i = 0; i < m->pages; i++)
        free(m->piece[i].key);
    free(m->piece);
    free(m);
}

void sga_exec_range(const struct sga_exec *m, void **base, size_t *bytes)
{
    *base = m->base;
    *bytes = m->bytes;
}

/* The first of so many pages in a row that nobody uses, or -1. */
static int find_room(const struct sga_exec *m, int pages)
{
    for (int from = 0, i; from + pages <= m->pages; from = i + m->piece[i].pages) {
        for (i = from; i < from + pages && !m->piece[i].users;)
            i++;
        if (i == from + pages)
            return from;
    }
    return -1;
}

/* Room where nothing is kept, or else where what is kept goes. */
static int take_room(struct sga_exec *m, int pages)
{
    int run = 0;
    for (int i = 0; i < m->pages && run < pages; i += m->piece[i].pages ? m->piece[i].pages : 1) {
        run = m->piece[i].pages ? 0 : run + 1;
        if (run == pages)
            return i + 1 - pages;
    }
    int first = find_room(m, pages);
    for (int i = 0; i < m->pages && first >= 0; i++) {
        const struct piece *q = m->piece + i;
        if (q->pages && i < first + pages && i + q->pages > first) {
            free(q->key);
            m->piece[i] = (struct piece){ 0 };
        }
    }
    return first;
}

static uint64_t mix(uint64_t h, uint64_t word)
{
    h = (h ^ word) * 0x9E3779B97F4A7C15u;
    return h ^ (h >> 29);
}

static uint64_t hash_of(const void *code, size_t bytes)
{
    uint64_t h = bytes, word;
    const unsigned char *at = code;
    for (; bytes >= sizeof word; bytes -= sizeof word, at += sizeof word) {
        memcpy(&word, at, sizeof word);
        h = mix(h, word);
    }
    word = 0;
    memcpy(&word, at, bytes);
    return mix(h, word);
}

/* The same code as was added before, or -1. */
static int find_same(const struct sga_exec *m, const void *code, size_t bytes, uint64_t hash)
{
    for (int i = 0; i < m->pages; i += m->piece[i].pages ? m->piece[i].pages : 1)
        if (m->piece[i].bytes == bytes && m->piece[i].hash == hash && memcmp(m->base + (size_t)i * PAGE, code, bytes) == 0)
            return i;
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
    if (bytes == 0 || bytes > m->bytes)
        return NULL;
    uint64_t hash = hash_of(code, bytes);
    int pages = (int)((bytes + PAGE - 1) / PAGE), first = find_same(m, code, bytes, hash);
    if (first >= 0) {
        m->piece[first].users++;
        m->found++;
        return m->base + (size_t)first * PAGE;
    }
    first = m->refused ? -1 : take_room(m, pages);
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
    m->piece[first] = (struct piece){ .pages = pages, .users = 1, .hash = hash, .bytes = bytes };
    m->made++;
    return at;
}

const void *sga_exec_known(struct sga_exec *m, const void *key, size_t bytes)
{
    uint64_t hash = hash_of(key, bytes);
    for (int i = 0; i < m->pages; i += m->piece[i].pages ? m->piece[i].pages : 1) {
        struct piece *q = m->piece + i;
        if (q->key && q->key_hash == hash && q->key_bytes == bytes && memcmp(q->key, key, bytes) == 0) {
            q->users++;
            m->found++;
            return m->base + (size_t)i * PAGE;
        }
    }
    return NULL;
}

void sga_exec_name(struct sga_exec *m, const void *at, const void *key, size_t bytes)
{
    size_t page = (size_t)((const unsigned char *)at - m->base) / PAGE;
    assert(page < (size_t)m->pages && m->piece[page].users > 0);
    struct piece *q = m->piece + page;
    if (q->key)
        return;
    q->key = sga_malloc(bytes);
    memcpy(q->key, key, bytes);
    q->key_bytes = bytes;
    q->key_hash = hash_of(key, bytes);
}

bool sga_exec_repeats(const struct sga_exec *m) { return m->found > 2 * m->made; }

void sga_exec_drop(struct sga_exec *m, const void *at)
{
    size_t page = (size_t)((const unsigned char *)at - m->base) / PAGE;
    assert(page < (size_t)m->pages && m->piece[page].users > 0);
    m->piece[page].users--;
}
