/* Arenas: blocks that do not overlap, ends in order, marks, and what a block of code gives back. */
#include <stdint.h>

#include "arena.h"
#include "check.h"
#include "mem.h"

enum { BLOCKS = 400 };

static int order[8], ended;

static void note(void *object)
{
    order[ended++ & 7] = *(int *)object;
}

/* Each block keeps its own bytes, whatever the sizes beside it. */
static void blocks_apart(void)
{
    SGA_ARENA(mem);
    unsigned char *block[BLOCKS];
    size_t size[BLOCKS];
    for (int k = 0; k < BLOCKS; k++) {
        size[k] = k % 37 == 5 ? 20000 + (size_t)k : (size_t)(k * k) % 700;
        block[k] = k % 2 ? sga_take(&mem, size[k]) : sga_zeros(&mem, size[k], 1);
        CHECK((uintptr_t)block[k] % 16 == 0);
        for (size_t i = 0; i < size[k]; i++) {
            CHECK(k % 2 || !block[k][i]);
            block[k][i] = (unsigned char)(k + 1);
        }
    }
    for (int k = 0; k < BLOCKS; k++)
        for (size_t i = 0; i < size[k]; i++)
            CHECK(block[k][i] == (unsigned char)(k + 1));
}

/* Newest first, before the memory that they lie in. */
static void ends_in_order(void)
{
    ended = 0;
    {
        SGA_ARENA(mem);
        for (int k = 0; k < 3; k++) {
            int *at = sga_take(&mem, sizeof *at);
            *at = k;
            SGA_AT_END(&mem, note, at);
        }
        CHECK(sga_keep(&mem, sga_strdup("freed with it")) != NULL);
        CHECK(ended == 0);
    }
    CHECK(ended == 3 && order[0] == 2 && order[1] == 1 && order[2] == 0);
}

/* A loop between mark and release stays within its first turn's memory. */
static void marks(void)
{
    SGA_ARENA(mem);
    int *kept = sga_take(&mem, sizeof *kept), seven = 7;
    *kept = 11;
    ended = 0;
    struct sga_mark m = sga_arena_mark(&mem);
    char *first = NULL;
    for (int turn = 0; turn < 1000; turn++) {
        char *p = sga_take(&mem, 300);
        memset(p, turn, 300);
        memset(sga_take(&mem, 900), turn, 900);
        memset(sga_take(&mem, 30000), turn, 30000);
        SGA_AT_END(&mem, note, &seven);
        if (!turn)
            first = p;
#if !defined(__SANITIZE_ADDRESS__)
        CHECK(p == first);
#endif
        sga_arena_release(&mem, &m);
        CHECK(ended == turn + 1 && mem.at == m.was.at && mem.large == m.was.large);
    }
    CHECK(first && *kept == 11);
    sga_arena_end(&mem);
    CHECK(!mem.chunk && !mem.room && *(int *)memcpy(sga_take(&mem, sizeof seven), &seven, sizeof seven) == 7);
}

/* The value of a return stands before its memory goes. */
static int sum_to(int n)
{
    SGA_ARENA(mem);
    int *v = sga_take(&mem, (size_t)n * sizeof *v), sum = 0;
    for (int i = 0; i < n; i++)
        v[i] = i + 1;
    if (n == 3)
        return v[0] + v[1] + v[2];
    for (int i = 0; i < n; i++)
        sum += v[i];
    return sum;
}

static void vectors(void)
{
    SGA_ARENA(mem);
    int *v = NULL;
    size_t cap = 0;
    for (int i = 0; i < 5000; i++) {
        SGA_RESERVE_IN(&mem, v, cap, i + 1);
        v[i] = i;
    }
    for (int i = 0; i < 5000; i++)
        CHECK(v[i] == i);
    CHECK(cap >= 5000 && cap < 10000);
    CHECK(strcmp(sga_take_text(&mem, "a text"), "a text") == 0);
}

static int freed_late(void)
{
    SGA_FREED int *grown = NULL;
    size_t cap = 0;
    SGA_RESERVE(grown, cap, 100);
    grown[99] = 5;
    return grown[99];
}

int main(void)
{
    blocks_apart();
    ends_in_order();
    marks();
    vectors();
    CHECK(sum_to(3) == 6 && sum_to(100) == 5050);
    CHECK(freed_late() == 5);
    return CHECK_END();
}
