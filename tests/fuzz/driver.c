/* A small coverage-guided fuzzer for any compiler: TARGET [--seconds S] [--seed N] [--last FILE] FOLDER
 *
 * Runs each file of the folder as it is, then mutations of them until the time is over. An
 * input that reaches edges of the program which no input reached before joins the pool
 * (-fsanitize-coverage=trace-pc tells, in the code under test). The input that is being run
 * stands in the file LAST, mapped, so that it is there however the process dies; a whole run
 * removes it. The seed is printed, and the same seed makes the same mutations. */
#include "fuzz.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdbool.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

enum { MOST = 1 << 16, EDGES = 1 << 16, POOL = 4096, PATIENCE = 30 };

struct input {
    uint8_t *data;
    size_t size;
};

static struct input pool[POOL];
static int inputs;
static unsigned char reached[EDGES];
static bool new_edge;
static uint64_t state;
static struct last { uint64_t size; uint8_t data[MOST]; } *last;

/* Called at each basic block of instrumented code, also from the threads of the code under
 * test: a lost update costs an input that is not kept. */
__attribute__((no_sanitize("address", "undefined"))) void __sanitizer_cov_trace_pc(void);
__attribute__((no_sanitize("address", "undefined"))) void __sanitizer_cov_trace_pc(void)
{
    static _Thread_local uintptr_t before;
    uintptr_t at = (uintptr_t)__builtin_return_address(0);
    size_t edge = (at ^ (before >> 1)) * 0x9E3779B97F4A7C15ull >> 48;
    before = at;
    if (!reached[edge]) {
        reached[edge] = 1;
        new_edge = true;
    }
}

static uint32_t below(uint32_t n)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)(state >> 32) % n;
}

static void keep(const uint8_t *data, size_t size)
{
    int at = inputs < POOL ? inputs++ : (int)below(POOL);
    free(pool[at].data);
    pool[at] = (struct input){ malloc(size + 1), size };
    memcpy(pool[at].data, data, size);
}

/* The target gets a copy of just its size: a read past the end is seen. */
static void run(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size ? size : 1);
    memcpy(copy, data, size);
    memcpy(last->data, data, size);
    last->size = size;
    alarm(PATIENCE);
    LLVMFuzzerTestOneInput(copy, size);
    alarm(0);
    free(copy);
}

/* -- Mutations: each changes the input in place and keeps it within MOST -- */

static size_t insert(uint8_t *data, size_t size, size_t at, const void *piece, size_t n)
{
    if (n > MOST - size)
        n = MOST - size;
    uint8_t *copy = malloc(n + 1);          /* the piece may lie in the input itself */
    memcpy(copy, piece, n);
    memmove(data + at + n, data + at, size - at);
    memcpy(data + at, copy, n);
    free(copy);
    return size + n;
}

static size_t cut(uint8_t *data, size_t size, size_t at, size_t n)
{
    n = n < size - at ? n : size - at;
    memmove(data + at, data + at + n, size - at - n);
    return size - n;
}

static size_t mutate_once(uint8_t *data, size_t size)
{
    static const char odd[] = "\0\xff\x80\r\n\"\\{}[](),:;=*^'0 19e-+.%";
    int words = 0;
    while (fuzz_words[words])
        words++;
    size_t at = below((uint32_t)size + 1), n = 1 + below(below(4) ? 8 : 256);
    const struct input *other = &pool[below((uint32_t)inputs)];
    const char *word = fuzz_words[below((uint32_t)words)];
    switch (below(9)) {
    case 0:
        if (at < size)
            data[at] ^= (uint8_t)(1 << below(8));
        return size;
    case 1:
        if (at < size)
            data[at] = (uint8_t)odd[below(sizeof odd - 1)];
        return size;
    case 2:
        return cut(data, size, at, n);
    case 3:
        return insert(data, size, at, &odd[below(sizeof odd - 1)], 1);
    case 4:
        return insert(data, size, at, word, strlen(word));
    case 5:                                  /* a piece of the input once more */
        n = n < size - at ? n : size - at;
        return insert(data, size, below((uint32_t)size + 1), data + at, n);
    case 6:                                  /* a piece of another one */
        at = below((uint32_t)other->size + 1);
        n = n < other->size - at ? n : other->size - at;
        return insert(data, size, below((uint32_t)size + 1), other->data + at, n);
    case 7:                                  /* the beginning of this, the end of another */
        size = at;
        at = below((uint32_t)other->size + 1);
        return insert(data, size, size, other->data + at, other->size - at);
    default:                                 /* many times: depth, length, digits */
        for (uint32_t k = below(200); k > 0; k--)
            size = insert(data, size, at, word, strlen(word));
        return size;
    }
}

static void fuzz(double seconds)
{
    static uint8_t data[MOST];
    struct timespec begun, now;
    unsigned long runs = 0;
    int given = inputs;
    for (int i = 0; i < given; i++)
        run(pool[i].data, pool[i].size);
    clock_gettime(CLOCK_MONOTONIC, &begun);
    do {
        const struct input *from = &pool[below((uint32_t)inputs)];
        size_t size = from->size;
        memcpy(data, from->data, size);
        for (uint32_t k = 1 + below(4); k > 0; k--)
            size = mutate_once(data, size);
        new_edge = false;
        run(data, size);
        runs++;
        if (new_edge)
            keep(data, size);
        clock_gettime(CLOCK_MONOTONIC, &now);
    } while ((double)(now.tv_sec - begun.tv_sec) + 1e-9 * (double)(now.tv_nsec - begun.tv_nsec) < seconds);
    int edges = 0;
    for (int i = 0; i < EDGES; i++)
        edges += reached[i];
    printf("%d files, %lu mutations, %d inputs with new edges, %d edges\n", given, runs, inputs - given, edges);
}

static bool load(const char *folder)
{
    static uint8_t data[MOST];
    struct dirent **names;
    int n = scandir(folder, &names, NULL, alphasort);
    for (int i = 0; i < n; i++) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", folder, names[i]->d_name);
        FILE *f = names[i]->d_name[0] != '.' ? fopen(path, "rb") : NULL;
        if (f) {
            keep(data, fread(data, 1, sizeof data, f));
            fclose(f);
        }
        free(names[i]);
    }
    if (n >= 0)
        free(names);
    return inputs > 0;
}

static bool map_last(const char *path)
{
    int fd = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0 || ftruncate(fd, sizeof *last) != 0)
        return false;
    last = mmap(NULL, sizeof *last, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    return last != MAP_FAILED;
}

int main(int argc, char **argv)
{
    double seconds = 10;
    const char *folder = NULL, *path = "fuzz-last";
    unsigned long seed = 20261121;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--seconds") == 0 && i + 1 < argc)
            seconds = atof(argv[++i]);
        else if (strcmp(argv[i], "--seed") == 0 && i + 1 < argc)
            seed = strtoul(argv[++i], NULL, 10);
        else if (strcmp(argv[i], "--last") == 0 && i + 1 < argc)
            path = argv[++i];
        else
            folder = argv[i];
    }
    if (!folder || !load(folder) || !map_last(path)) {
        fprintf(stderr, "usage: %s [--seconds S] [--seed N] [--last FILE] FOLDER\n", argv[0]);
        return 2;
    }
    printf("seed %lu\n", seed);
    fflush(stdout);
    state = seed * 0x9E3779B97F4A7C15ull | 1;
    LLVMFuzzerInitialize(&argc, &argv);
    fuzz(seconds);
    fuzz_end();
    for (int i = 0; i < inputs; i++)
        free(pool[i].data);
    munmap(last, sizeof *last);
    unlink(path);
    return 0;
}
