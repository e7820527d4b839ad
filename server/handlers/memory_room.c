/* Asking for memory and giving it back: what malloc would refuse a moment later is refused now. */
#include "memory_room.h"

#include <sys/mman.h>

/* The canonical text, its growing copies, and the job; trees and numbers are a child's matter. */
static const size_t READING = (size_t)8 << 20;
enum { BODY_FACTOR = 4 };

bool room_for_reading(size_t body)
{
    size_t need = READING + BODY_FACTOR * body;
    void *p = mmap(NULL, need, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (p == MAP_FAILED)
        return false;
    munmap(p, need);
    return true;
}
