/* See sort.h. */
#include "sort.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"

enum { SHORT = 32, BITS = 8, DIGITS = 1 << BITS };

static void insert(int *list, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        int v = list[i];
        size_t k = i;
        for (; k > 0 && list[k - 1] > v; k--)
            list[k] = list[k - 1];
        list[k] = v;
    }
}

/* By one digit of what is above `low`. */
static void pass(const int *from, int *to, size_t count, int low, int shift)
{
    size_t at[DIGITS] = { 0 }, sum = 0;
    for (size_t i = 0; i < count; i++)
        at[((unsigned)from[i] - (unsigned)low) >> shift & (DIGITS - 1)]++;
    for (int d = 0; d < DIGITS; d++) {
        size_t here = at[d];
        at[d] = sum;
        sum += here;
    }
    for (size_t i = 0; i < count; i++)
        to[at[((unsigned)from[i] - (unsigned)low) >> shift & (DIGITS - 1)]++] = from[i];
}

void sga_sort(int *list, size_t count)
{
    int few[DIGITS], low = count ? list[0] : 0, high = low, sorted = 1;
    for (size_t i = 1; i < count; i++) {
        low = list[i] < low ? list[i] : low;
        high = list[i] > high ? list[i] : high;
        sorted &= list[i - 1] <= list[i];
    }
    if (sorted)
        return;
    if (count <= SHORT) {
        insert(list, count);
        return;
    }
    int *from = list, *to = count <= DIGITS ? few : sga_malloc(count * sizeof *to), *own = to;
    for (int shift = 0; shift < 32 && ((unsigned)high - (unsigned)low) >> shift; shift += BITS) {
        pass(from, to, count, low, shift);
        int *swap = from;
        from = to;
        to = swap;
    }
    if (from != list)
        memcpy(list, from, count * sizeof *list);
    if (own != few)
        free(own);
}
