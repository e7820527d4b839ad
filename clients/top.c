/* The picture is made of /metrics alone: counters become rates between two looks. */
#include "top.h"
#include "budget.h"
#include "http_client.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* One look: the text as it came. */
struct look {
    struct sga_buf text;
    double at;
};

/* The sum of all series of a metric whose labels contain `with` (NULL: all). */
static double total(const struct look *l, const char *name, const char *with)
{
    size_t n = strlen(name);
    double sum = 0;
    const char *text = l->text.data ? l->text.data : "";
    for (const char *line = text; *line; line += strcspn(line, "\n"), line += *line == '\n') {
        if (strncmp(line, name, n) != 0 || (line[n] != ' ' && line[n] != '{'))
            continue;
        const char *end = line + strcspn(line, "\n"), *labels = line + n;
        const char *value = end;
        while (value > labels && value[-1] != ' ')
            value--;
        const char *found = with ? strstr(labels, with) : labels;
        if (found && found < end)
            sum += strtod(value, NULL);
    }
    return sum;
}

static double rate(const struct look *now, const struct look *before, const char *name, const char *with)
{
    double seconds = now->at - before->at;
    return before->text.len && seconds > 0 ? (total(now, name, with) - total(before, name, with)) / seconds : 0;
}

static double mean(const struct look *l, const char *sum, const char *count, const char *with)
{
    double n = total(l, count, with);
    return n > 0 ? total(l, sum, with) / n : 0;
}

/* `name`'s values of one label, one line each: those above 0. */
static void each(const struct look *l, const char *name, const char *label, struct sga_buf *out)
{
    size_t n = strlen(name), k = strlen(label);
    const char *text = l->text.data ? l->text.data : "";
    for (const char *line = text; *line; line += strcspn(line, "\n"), line += *line == '\n') {
        if (strncmp(line, name, n) != 0 || line[n] != '{' || strncmp(line + n + 1, label, k) != 0)
            continue;
        const char *value = line + n + 1 + k + 2, *rest = strstr(value, "} ");
        double v = rest ? strtod(rest + 2, NULL) : 0;
        if (v > 0)
            sga_buf_printf(out, "  %.*s %.0f", (int)strcspn(value, "\""), value, v);
    }
    sga_buf_puts(out, "\n");
}

static void show(const char *url, const struct look *now, const struct look *before, struct sga_buf *out)
{
    double hits = total(now, "sgad_cache_hits_total", NULL), misses = total(now, "sgad_cache_misses_total", NULL);
    sga_buf_printf(out, "sgad at %s    %s    store %s\n\n", url, total(now, "sgad_ready", NULL) > 0 ? "ready" : "NOT READY",
                   total(now, "sgad_store_healthy", NULL) > 0 ? "healthy" : "FAILING");
    sga_buf_printf(out, "jobs        queued %.0f (%.0f bytes)  running %.0f  accepted %.1f/s\n", total(now, "sgad_queue_depth", NULL),
                   total(now, "sgad_queue_bytes", NULL), total(now, "sgad_jobs", "status=\"running\""),
                   rate(now, before, "sgad_jobs_accepted_total", NULL));
    sga_buf_puts(out, "at stage  "), each(now, "sgad_jobs_at_stage", "stage", out);
    sga_buf_puts(out, "ended     "), each(now, "sgad_jobs_ended_total", "status", out);
    sga_buf_printf(out, "mean        job %.4g s  request %.4g s  wait in the queue %.4g s\n",
                   mean(now, "sgad_job_duration_seconds_sum", "sgad_job_duration_seconds_count", NULL),
                   mean(now, "sgad_http_request_duration_seconds_sum", "sgad_http_request_duration_seconds_count", NULL),
                   mean(now, "sgad_stage_duration_seconds_sum", "sgad_stage_duration_seconds_count", "stage=\"queued\""));
    sga_buf_printf(out, "requests    %.1f/s  connections %.0f  waiting %.0f  event streams %.0f\n", rate(now, before, "sgad_http_requests_total", NULL),
                   total(now, "sgad_connections", NULL), total(now, "sgad_waiters", NULL), total(now, "sgad_event_streams", NULL));
    sga_buf_printf(out, "cache       hits %.1f/s  share %.0f %%\n", rate(now, before, "sgad_cache_hits_total", NULL),
                   hits + misses > 0 ? 100 * hits / (hits + misses) : 0);
    sga_buf_printf(out, "children    started %.0f  died %.0f  killed %.0f\n", total(now, "sgad_child_starts_total", NULL),
                   total(now, "sgad_child_deaths_total", NULL), total(now, "sgad_child_kills_total", NULL));
    sga_buf_puts(out, "refused   "), each(now, "sgad_refusals_total", "code", out);
}

static bool fetch(const struct http_server *server, struct look *l)
{
    struct http_reply reply;
    char why[512];
    if (!http_ask(server, "GET", "/metrics", NULL, 0, 0, &reply, why, sizeof why)) {
        fprintf(stderr, "sga: %s\n", why);
        return false;
    }
    sga_buf_free(&l->text);
    *l = (struct look){ .text = reply.body, .at = sga_now() };
    if (reply.status == 200 && l->text.len)
        return true;
    fprintf(stderr, "sga: the daemon answers /metrics with status %d%s\n", reply.status,
            reply.status == 401 || reply.status == 403 ? "; set SGA_TOKEN to a token with the scope read" : "");
    return false;
}

int top_run(const char *url, double seconds, bool once)
{
    struct http_server server;
    struct look now = { .at = 0 }, before = { .at = 0 };
    bool ok = http_parse(url, &server), screen = isatty(STDOUT_FILENO) && !once;
    if (!ok)
        fprintf(stderr, "sga: '%s' is no address of the form http://HOST:PORT, https://HOST:PORT or unix:PATH\n", url);
    while (ok && (ok = fetch(&server, &now))) {
        struct sga_buf out = { 0 };
        if (screen)
            sga_buf_puts(&out, "\033[H\033[2J");
        show(url, &now, &before, &out);
        ok = fwrite(out.data, 1, out.len, stdout) == out.len && fflush(stdout) == 0;
        sga_buf_free(&out);
        if (once)
            break;
        sga_buf_free(&before.text);
        before = now;
        now = (struct look){ .at = 0 };
        struct timespec pause = { .tv_sec = (time_t)seconds, .tv_nsec = (long)(1e9 * (seconds - (double)(time_t)seconds)) };
        nanosleep(&pause, NULL);
    }
    sga_buf_free(&now.text);
    sga_buf_free(&before.text);
    return ok ? 0 : 1;
}
