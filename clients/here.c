/* Solving in process: the library's face, nothing more. */
#include "problem.h"
#include "request.h"
#include "run.h"

#include <stdio.h>

static void describe(const struct sga_error *err, char *out, size_t size)
{
    int n = snprintf(out, size, "%s", sga_code_text(err->code));
    if (*err->pointer && n < (int)size)
        n += snprintf(out + n, size - (size_t)n, " at %s", err->pointer);
    if (err->line > 0 && n < (int)size)
        n += snprintf(out + n, size - (size_t)n, ", line %d, column %d", err->line, err->column);
    if (n < (int)size)
        snprintf(out + n, size - (size_t)n, ": %s", *err->detail ? err->detail : sga_code_title(err->code));
}

bool solve_here(const char *request, size_t length, struct answer *a)
{
    struct sga_run_options options = { .max_seconds = 0 };
    struct sga_error err = { 0 };
    sga_init();
    if (sga_run(request, length, &options, &a->text, &err))
        return true;
    describe(&err, a->problem, sizeof a->problem);
    struct sga_json w;
    sga_buf_clear(&a->text);
    sga_json_begin(&w, &a->text);
    problem_write(&w, &err);
    return false;
}
