/* The public face: sga_run and sga_canonical for programs that are not ours. */
#include "sga.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "mem.h"
#include "run.h"

struct sga_answer {
    bool ok;
    struct sga_buf text;
    struct sga_error err;
};

/* Bytes of machine code of formulas. */
static const size_t CODE = 4 << 20;

static pthread_once_t once = PTHREAD_ONCE_INIT;

/* What the host calls with, by way of what a run is called with. */
struct host { const struct sga_options *options; };

static void progress(void *ctx, const char *stage, double fraction, double t)
{
    (void)t;
    const struct host *h = ctx;
    h->options->progress(h->options->context, stage, fraction);
}

static bool cancelled(void *ctx)
{
    const struct host *h = ctx;
    return h->options->cancelled(h->options->context) != 0;
}

static struct sga_answer *begin(void)
{
    pthread_once(&once, sga_init_guest);
    return sga_calloc(1, sizeof(struct sga_answer));
}

int sga_api(void)
{
    return SGA_API;
}

/* As much of the options as the caller's header knew. */
static struct sga_options known(const struct sga_options *given)
{
    struct sga_options o = { .size = sizeof o };
    if (given)
        memcpy(&o, given, given->size && given->size < sizeof o ? given->size : sizeof o);
    return o;
}

struct sga_answer *sga_solve(const char *request, size_t length, const struct sga_options *given)
{
    struct sga_answer *a = begin();
    struct sga_options o = known(given);
    struct host host = { &o };
    struct sga_run_options run = {
        .max_seconds = o.seconds, .max_memory = o.memory, .max_result = o.result, .progress = o.progress ? progress : NULL,
        .cancelled = o.cancelled ? cancelled : NULL, .ctx = &host, .exec = o.interpret_only ? NULL : sga_exec_new(CODE) };
    a->ok = sga_run(request, length, &run, &a->text, &a->err);
    sga_exec_free(run.exec);
    return a;
}

struct sga_answer *sga_check(const char *request, size_t length)
{
    struct sga_answer *a = begin();
    a->ok = sga_canonical(request, length, &a->text, &a->err);
    return a;
}

int sga_answer_ok(const struct sga_answer *a)
{
    return a->ok;
}

const char *sga_answer_text(const struct sga_answer *a)
{
    return a->ok && a->text.data ? a->text.data : "";
}

size_t sga_answer_length(const struct sga_answer *a)
{
    return a->ok ? a->text.len : 0;
}

const char *sga_answer_code(const struct sga_answer *a)
{
    return sga_code_text(a->ok ? SGA_E_OK : a->err.code);
}

const char *sga_answer_title(const struct sga_answer *a)
{
    return sga_code_title(a->ok ? SGA_E_OK : a->err.code);
}

const char *sga_answer_detail(const struct sga_answer *a)
{
    return a->ok ? "" : a->err.detail;
}

const char *sga_answer_pointer(const struct sga_answer *a)
{
    return a->ok ? "" : a->err.pointer;
}

const char *sga_answer_stage(const struct sga_answer *a)
{
    return a->ok ? "" : a->err.stage;
}

int sga_answer_line(const struct sga_answer *a)
{
    return a->ok ? 0 : a->err.line;
}

int sga_answer_column(const struct sga_answer *a)
{
    return a->ok ? 0 : a->err.column;
}

void sga_answer_free(struct sga_answer *a)
{
    if (!a)
        return;
    sga_buf_free(&a->text);
    free(a);
}
