/* A fuzz target: one function with libFuzzer's name and meaning, linked either with driver.c
 * (any compiler) or with libFuzzer (clang). A fault ends the process: a sanitizer's report, or
 * FUZZ_REQUIRE, which says what should have held. */
#ifndef TESTS_FUZZ_FUZZ_H
#define TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
/* Texts that the mutator inserts, NULL-terminated, and an end before leaks are looked for;
 * both are asked for by driver.c only. */
extern const char *const fuzz_words[];
void fuzz_end(void);

#define FUZZ_REQUIRE(cond, ...) \
    do { \
        if (!(cond)) { \
            fprintf(stderr, "%s:%d: %s: ", __FILE__, __LINE__, #cond); \
            fprintf(stderr, __VA_ARGS__); \
            fprintf(stderr, "\n"); \
            abort(); \
        } \
    } while (0)

#endif
