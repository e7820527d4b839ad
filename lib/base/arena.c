/* Chunks double, so that n bytes cost log n mallocs; a block too large for them has its own, and leaves the chunk in use. */
#include "arena.h"

#include <assert.h>
#include <stdbool.h>

#include "mem.h"

struct sga_chunk {
    struct sga_chunk *below;
    size_t size;               /* of what follows; a malloc is aligned to 16, and so is this */
};

struct sga_end {
    struct sga_end *below;
    sga_clear *clear;
    void *object;
};

#if defined(__SANITIZE_ADDRESS__)
enum { FIRST = 1024, LAST = 0, LARGE = -1 };          /* every block is large */
#else
enum { FIRST = 1024, LAST = 1 << 16, LARGE = 1 << 13 };
#endif

_Static_assert(sizeof(struct sga_chunk) % 16 == 0, "blocks are aligned to 16");

static char *start(struct sga_chunk *c)
{
    return (char *)(c + 1);
}

static void *take_large(struct sga_arena *a, size_t size, bool zeros)
{
    size_t all = size > SIZE_MAX - sizeof(struct sga_chunk) ? SIZE_MAX : sizeof(struct sga_chunk) + size;
    struct sga_chunk *c = zeros ? sga_calloc(1, all) : sga_malloc(all);
    *c = (struct sga_chunk){ a->large, size };
    a->large = c;
    return start(c);
}

static bool is_large(size_t size)
{
    return LARGE < 0 || size > (size_t)LARGE;
}

void *sga_take_chunk(struct sga_arena *a, size_t size)
{
    if (is_large(size))
        return take_large(a, size, false);
    size_t all = a->chunk ? 2 * (a->chunk->size + sizeof *a->chunk) : FIRST;
    while (all < size + 16 + sizeof *a->chunk)
        all *= 2;
    if (all > LAST)
        all = LAST;
    struct sga_chunk *c = sga_malloc(all);
    *c = (struct sga_chunk){ a->chunk, all - sizeof *c };
    a->chunk = c;
    a->at = start(c);
    a->room = c->size;
    assert(a->room > size && (uintptr_t)a->at % 16 == 0);
    return sga_take(a, size);
}

void *sga_zeros(struct sga_arena *a, size_t count, size_t size)
{
    size_t all = count && size > SIZE_MAX / count ? SIZE_MAX : count * size;
    if (is_large(all))
        return take_large(a, all, true);           /* fresh pages are zeros already */
    return memset(sga_take(a, all), 0, all);
}

char *sga_take_text(struct sga_arena *a, const char *s)
{
    size_t n = strlen(s) + 1;
    return memcpy(sga_take(a, n), s, n);
}

void *sga_take_longer(struct sga_arena *a, const void *p, size_t size, size_t *cap, size_t need)
{
    size_t was = *cap, now = was ? was : 16;
    while (now < need)
        now *= 2;
    *cap = now;
    void *longer = sga_take(a, now > SIZE_MAX / size ? SIZE_MAX : now * size);
    return was ? memcpy(longer, p, was * size) : longer;
}

void sga_arena_at_end(struct sga_arena *a, sga_clear *clear, void *object)
{
    struct sga_end *e = sga_take(a, sizeof *e);
    *e = (struct sga_end){ a->ends, clear, object };
    a->ends = e;
}

void *sga_keep(struct sga_arena *a, void *p)
{
    sga_arena_at_end(a, free, p);
    return p;
}

/* Down to what was there at the mark. */
static struct sga_chunk *drop(struct sga_chunk *c, const struct sga_chunk *last)
{
    while (c != last) {
        assert(c);             /* a mark of another arena, or one that was released past */
        struct sga_chunk *below = c->below;
        free(c);
        c = below;
    }
    return c;
}

void sga_arena_release(struct sga_arena *a, const struct sga_mark *m)
{
    for (; a->ends != m->was.ends; a->ends = a->ends->below) {
        assert(a->ends);
        a->ends->clear(a->ends->object);
    }
    a->chunk = drop(a->chunk, m->was.chunk);
    a->large = drop(a->large, m->was.large);
    a->at = m->was.at;
    a->room = m->was.room;
}

void sga_arena_drop(struct sga_arena *a)
{
    sga_arena_release(a, &(struct sga_mark){ 0 });
}
