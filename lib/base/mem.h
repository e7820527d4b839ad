/* Allocation for the algebra. These never return NULL: when memory ends the
 * process ends, as it does inside GMP, with last words where a job is watched
 * (watch.h); the daemon runs the algebra in a child process for that reason and
 * reports one failed job. The server itself must not use them for sizes that a
 * client chooses. GMP and FLINT allocate by them too. */
#ifndef SGA_BASE_MEM_H
#define SGA_BASE_MEM_H

#include <stddef.h>
#include <string.h>

void *sga_malloc(size_t size);
void *sga_calloc(size_t count, size_t size);
void *sga_realloc(void *p, size_t size);
char *sga_strdup(const char *s);
/* For libraries that can bear it: NULL where memory ends, which is noted (watch.h). */
void *sga_try_malloc(size_t size);
/* Zeros, of which what is never touched costs nothing, however large and however often: from a megabyte on pages of the system's own, which
 * malloc would keep and wipe again. Freed with the same size; NULL is allowed. */
void *sga_zero_pages(size_t size);
void sga_zero_pages_free(void *p, size_t size);
/* The same, larger: what is added is zeros, and the old pages are moved, not copied. p may be NULL (old 0). */
void *sga_zero_pages_grow(void *p, size_t old, size_t size);

/* Copies n doubles one at a time. For the few that were just written one at a time: memcpy
 * reads them in wider pieces, and the processor then waits until the single writes are done
 * (it cannot forward them). The empty statement keeps the loop from becoming a memcpy. */
static inline void sga_copy(double *to, const double *from, int n)
{
    if (n > 32)
        memcpy(to, from, (size_t)n * sizeof *to);
    else
        for (int j = 0; j < n; j++) {
            to[j] = from[j];
            __asm__ volatile("");
        }
}

/* Grow a vector: makes room for at least `need` elements, doubling.
 * The macro's arguments are evaluated more than once. */
#define SGA_RESERVE(ptr, cap, need) \
    do { \
        if ((size_t)(cap) < (size_t)(need)) { \
            size_t cap_ = (size_t)(cap) ? (size_t)(cap) : 16; \
            while (cap_ < (size_t)(need)) \
                cap_ *= 2; \
            (ptr) = sga_realloc((ptr), cap_ * sizeof *(ptr)); \
            (cap) = cap_; \
        } \
    } while (0)

#endif
