/* Runs one request in process and says what it cost: measure FILE [RUNS [code]]
 *
 * Prints one line of JSON: the best and the mean CPU seconds of a run, from text to
 * text, what part of the time that passed `work.seconds` accounts for (the best of the runs), and the peak
 * memory of the process in KiB. code: formulas may become machine code, as in the program. Benchmarks start one process for
 * each measurement, so that the peak belongs to it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "error.h"
#include "run.h"

static const size_t CODE = 4 << 20;      /* bytes, as in the program */

static char *read_file(const char *path, size_t *length)
{
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END))
        return NULL;
    long n = ftell(f);
    char *text = n < 0 ? NULL : malloc((size_t)n + 1);
    rewind(f);
    *length = text ? fread(text, 1, (size_t)n, f) : 0;
    fclose(f);
    return text;
}

/* The peak of this program alone: getrusage would count what the parent was before exec. */
static long peak_kib(void)
{
    FILE *f = fopen("/proc/self/status", "r");
    char line[256];
    long kib = 0;
    while (f && fgets(line, sizeof line, f))
        if (sscanf(line, "VmHWM: %ld", &kib) == 1)
            break;
    if (f)
        fclose(f);
    return kib;
}

/* work.seconds.total of a result; 0 where it has none. */
static double accounted(const struct sga_buf *out)
{
    const char *at = out->data ? strstr(out->data, "\"work\"") : NULL;
    at = at ? strstr(at, "\"total\":") : NULL;
    return at ? strtod(at + strlen("\"total\":"), NULL) : 0;
}

int main(int argc, char **argv)
{
    size_t length = 0;
    char *text = argc > 1 ? read_file(argv[1], &length) : NULL;
    int runs = argc > 2 ? atoi(argv[2]) : 1;
    if (!text || runs < 1) {
        fprintf(stderr, "usage: measure FILE [RUNS [code]]\n");
        return 2;
    }
    double best = 0, sum = 0, part = 0;
    size_t bytes = 0;
    for (int i = 0; i < runs; i++) {
        struct sga_buf out = { 0 };
        struct sga_error err = { 0 };
        double begun = sga_cpu(), since = sga_now();
        struct sga_run_options options = { .exec = argc > 3 ? sga_exec_new(CODE) : NULL };
        if (!sga_run(text, length, argc > 3 ? &options : NULL, &out, &err)) {
            fprintf(stderr, "measure: %s: %s\n", sga_code_text(err.code), err.detail);
            return 1;
        }
        sga_exec_free(options.exec);
        double took = sga_cpu() - begun, passed = sga_now() - since;
        part = accounted(&out) / passed > part ? accounted(&out) / passed : part;
        best = i == 0 || took < best ? took : best;
        sum += took;
        bytes = out.len;
        sga_buf_free(&out);
    }
    printf("{\"runs\": %d, \"best\": %.9f, \"mean\": %.9f, \"accounted\": %.4f, \"peak_kib\": %ld, \"result_bytes\": %zu}\n", runs, best,
           sum / runs, part, peak_kib(), bytes);
    free(text);
    return 0;
}
