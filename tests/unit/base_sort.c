/* Lists of all lengths around the limits of the ways they are sorted by, and of numbers at the ends of int. */
#include "sort.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

enum { MOST = 1200 };

static int by_value(const void *a, const void *b)
{
    int x = *(const int *)a, y = *(const int *)b;
    return (x > y) - (x < y);
}

static unsigned random_bits(void)
{
    static unsigned long long state = 11;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (unsigned)(state >> 33) ^ (unsigned)(state >> 1);
}

static void like_qsort(const int *list, size_t count, const char *what)
{
    static int a[MOST], b[MOST];
    memcpy(a, list, count * sizeof *a);
    memcpy(b, list, count * sizeof *b);
    sga_sort(a, count);
    if (count)
        qsort(b, count, sizeof *b, by_value);
    CHECK(!memcmp(a, b, count * sizeof *a), "%s, %zu", what, count);
}

int main(void)
{
    static const unsigned range[] = { 0, 3, 200, 70000, 1u << 30, UINT_MAX };
    static const size_t count[] = { 0, 1, 2, 31, 32, 33, 255, 256, 257, MOST };
    int list[MOST];
    for (size_t r = 0; r < sizeof range / sizeof *range; r++)
        for (size_t c = 0; c < sizeof count / sizeof *count; c++) {
            for (size_t i = 0; i < count[c]; i++)
                list[i] = (int)(range[r] == UINT_MAX ? random_bits() : random_bits() % (range[r] + 1) - range[r] / 2);
            like_qsort(list, count[c], "random");
            for (size_t i = 0; i < count[c]; i++)
                list[i] = (int)(count[c] - i);
            like_qsort(list, count[c], "falling");
        }
    int ends[] = { INT_MAX, 0, INT_MIN, -1, INT_MAX, INT_MIN, 1 };
    like_qsort(ends, sizeof ends / sizeof *ends, "ends");
    for (int i = 0; i < 300; i++)
        list[i] = i % 3 ? i % 2 ? INT_MIN : INT_MAX : i - 150;
    like_qsort(list, 300, "ends, many");
    return CHECK_END();
}
