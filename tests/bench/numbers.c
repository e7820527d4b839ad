/* What formatting costs: numbers FILE, doubles as they lie in memory.
 *
 * Prints one line of JSON: CPU seconds for all of them, the best of some runs, by printf with
 * 17 digits and by the writer of results. */
#include <stdio.h>
#include <stdlib.h>

#include "buf.h"
#include "budget.h"

enum { MOST = 1 << 20, RUNS = 40 };

static size_t by_printf(const double *v, size_t n)
{
    char text[64];
    size_t bytes = 0;
    for (size_t i = 0; i < n; i++)
        bytes += (size_t)snprintf(text, sizeof text, "%.17g,", v[i]);
    return bytes;
}

static size_t by_writer(const double *v, size_t n)
{
    struct sga_buf out = { 0 };
    struct sga_json w;
    sga_json_begin(&w, &out);
    sga_json_array(&w);
    for (size_t i = 0; i < n; i++)
        sga_json_double(&w, v[i]);
    sga_json_end_array(&w);
    size_t bytes = out.len;
    sga_buf_free(&out);
    return bytes;
}

static double best(size_t (*format)(const double *, size_t), const double *v, size_t n)
{
    double least = 1e9;
    size_t bytes = 0;
    for (int i = 0; i < RUNS; i++) {
        double begun = sga_cpu();
        bytes += format(v, n);
        double took = sga_cpu() - begun;
        least = took < least ? took : least;
    }
    return bytes ? least : 0;
}

int main(int argc, char **argv)
{
    double *v = malloc(MOST * sizeof *v);
    FILE *f = argc > 1 ? fopen(argv[1], "rb") : NULL;
    size_t n = f && v ? fread(v, sizeof *v, MOST, f) : 0;
    if (n == 0) {
        fprintf(stderr, "usage: numbers FILE\n");
        return 2;
    }
    fclose(f);
    printf("{\"count\": %zu, \"printf\": %.9f, \"writer\": %.9f}\n", n, best(by_printf, v, n), best(by_writer, v, n));
    free(v);
    return 0;
}
