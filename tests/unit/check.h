/* A tiny test runner. A place that is checked counts once, however often a loop comes by and as long as it holds each time; every
 * failure counts, prints its place and goes on. main() ends with `return CHECK_END();`, which prints "N passed, N failed". */
#ifndef TESTS_UNIT_CHECK_H
#define TESTS_UNIT_CHECK_H

#include <stdio.h>
#include <stdlib.h>

/* CHECK_SHARED: of several files, one of which defines them. */
#ifdef CHECK_SHARED
extern int check_passed, check_failed;
#else
static int check_passed, check_failed;
#endif

#define CHECK(cond, ...) \
    do { \
        static int check_seen; \
        if (cond) { \
            check_passed += !check_seen; \
            check_seen = 1; \
        } else { \
            check_failed++; \
            printf("%s:%d: %s", __FILE__, __LINE__, #cond); \
            printf("  " __VA_ARGS__); \
            printf("\n"); \
        } \
    } while (0)

#define CHECK_END() (printf("%d passed, %d failed\n", check_passed, check_failed), check_failed != 0)

/* The seed of a random test: SGA_TEST_SEED or the default; always printed. */
static inline unsigned long check_seed(unsigned long otherwise)
{
    const char *s = getenv("SGA_TEST_SEED");
    unsigned long seed = s ? strtoul(s, NULL, 10) : otherwise;
    printf("seed %lu\n", seed);
    return seed;
}

/* How many random cases: n times SGA_TEST_SCALE. */
static inline int check_scale(int n)
{
    const char *s = getenv("SGA_TEST_SCALE");
    double k = s ? atof(s) : 1.0;
    return (int)(n * k) > 0 ? (int)(n * k) : 1;
}

#endif
