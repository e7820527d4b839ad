/* Memory that ends with its owner: a function, a turn of a loop, a struct, a stage.
 *
 * An arena hands out blocks from chunks and drops them all at once; nothing in it is freed alone. In a function it ends
 * where its block of code ends, on every path:
 *
 *     SGA_ARENA(mem);
 *     int *order = sga_take(&mem, n * sizeof *order), *at = sga_zeros(&mem, n, sizeof *at);
 *
 * A struct whose parts live as long as itself has one as a member, and its clear function is sga_arena_end. What a function
 * gives back is never taken from its own arena. Chunks come from sga_malloc, so that a job's memory is counted (watch.h).
 * An arena belongs to one thread, and is empty when it is all zeros.
 *
 * Other things end with their block of code by SGA_ENDS: the function gets the variable's address, on every path after the
 * declaration, so that the declaration sets a state which it bears.
 *
 * Cost: taking is a comparison and an addition; a chunk costs one malloc, and an arena that nothing was taken from none.
 * Under the address sanitizer each block is a malloc of its own, so that a use beyond it or after its end is found. */
#ifndef SGA_BASE_ARENA_H
#define SGA_BASE_ARENA_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define SGA_ENDS(clear) __attribute__((cleanup(clear)))
/* end(x): what SGA_ENDS calls for a type that is cleared by clear(*x). */
#define SGA_END_BY(end, type, clear) static inline void end(type *x) { clear(*x); }

struct sga_chunk;
struct sga_end;

struct sga_arena {
    char *at;                  /* free memory of the newest chunk, aligned to 16 */
    size_t room;
    struct sga_chunk *chunk;   /* newest first */
    struct sga_chunk *large;   /* blocks with a chunk of their own, newest first */
    struct sga_end *ends;      /* what is to be cleared, newest first */
};

/* A state of an arena, to which it can return. */
struct sga_mark {
    struct sga_arena was;
};

typedef void sga_clear(void *object);

void *sga_take_chunk(struct sga_arena *a, size_t size);       /* for sga_take */
void sga_arena_drop(struct sga_arena *a);                     /* for sga_arena_end */

/* `size` bytes, aligned to 16; never NULL, as sga_malloc. */
static inline void *sga_take(struct sga_arena *a, size_t size)
{
    size_t need = (size + !size + 15) & ~(size_t)15;
    if (need > a->room || need < size)
        return sga_take_chunk(a, size);
    char *p = a->at;
    a->at += need;
    a->room -= need;
    return p;
}

/* The same, zeros. */
void *sga_zeros(struct sga_arena *a, size_t count, size_t size);
/* A copy of a text. */
char *sga_take_text(struct sga_arena *a, const char *s);
/* What was malloced by others, freed with the arena; the argument. */
void *sga_keep(struct sga_arena *a, void *p);
/* clear(object) when the arena ends, newest first, before any of its memory goes; the object may lie in it. */
void sga_arena_at_end(struct sga_arena *a, sga_clear *clear, void *object);
#define SGA_AT_END(arena, clear, object) ((void)sizeof((clear)(object), 0), sga_arena_at_end((arena), (sga_clear *)(clear), (object)))

/* A vector that grows in an arena, as SGA_RESERVE does: what it was stays behind, less than it is now. */
#define SGA_RESERVE_IN(arena, ptr, cap, need) \
    do { \
        if ((size_t)(cap) < (size_t)(need)) \
            (ptr) = sga_take_longer((arena), (ptr), sizeof *(ptr), &(cap), (size_t)(need)); \
    } while (0)
void *sga_take_longer(struct sga_arena *a, const void *p, size_t size, size_t *cap, size_t need);

/* For long loops: what was taken since the mark ends, in turn after turn. */
static inline struct sga_mark sga_arena_mark(const struct sga_arena *a)
{
    return (struct sga_mark){ *a };
}
void sga_arena_release(struct sga_arena *a, const struct sga_mark *m);

/* Everything ends; the arena is empty and can be used again. */
static inline void sga_arena_end(struct sga_arena *a)
{
    if (a->chunk || a->large)
        sga_arena_drop(a);
}
#define SGA_ARENA(name) SGA_ENDS(sga_arena_end) struct sga_arena name = { 0 }

/* A pointer whose memory others grow with realloc. */
static inline void sga_end_free(void *pointer)
{
    void *p;
    memcpy(&p, pointer, sizeof p);
    free(p);
}
#define SGA_FREED SGA_ENDS(sga_end_free)

#endif
