/* Prometheus text, format version 0.0.4. */
#include "metrics.h"

#include <stdio.h>
#include <string.h>

#include "buf.h"
#include "error.h"

static const char *const methods[METRICS_METHODS] = { "GET", "HEAD", "POST", "DELETE", "other" };
static const int statuses[METRICS_STATUSES] = { 200, 202, 204, 304, 400, 401, 403, 404, 405, 406, 409, 410, 413, 414, 415, 422, 429, 431, 500, 503, 505, 0 };
static const double bounds[METRICS_BUCKETS - 1] = { 1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100 };

static const struct { const char *name, *help; } counters[METRICS_COUNTERS_N] = {
#define X(sym, text, help_text) { text, help_text },
    METRICS_COUNTERS(X)
#undef X
};

static const char *const stages[METRICS_STAGES] = {
#define X(sym, name) name,
    METRICS_STAGES_TABLE(X)
#undef X
};

static void observe(struct histogram *h, double seconds)
{
    int i = 0;
    while (i < METRICS_BUCKETS - 1 && seconds > bounds[i])
        i++;
    atomic_fetch_add_explicit(&h->bucket[i], 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&h->microseconds, (unsigned long)(seconds * 1e6), memory_order_relaxed);
}

void metrics_http(struct metrics *m, int route, const char *method, int status)
{
    int k = 0, s = 0;
    while (k < METRICS_METHODS - 1 && strcmp(method, methods[k]) != 0)
        k++;
    while (statuses[s] && statuses[s] != status)
        s++;
    atomic_fetch_add_explicit(&m->http[route][k][s], 1, memory_order_relaxed);
}

void metrics_http_took(struct metrics *m, double seconds)
{
    observe(&m->request_seconds, seconds);
}

void metrics_committed(struct metrics *m, double seconds)
{
    observe(&m->commit_seconds, seconds);
}

void metrics_job(struct metrics *m, enum job_status status, double seconds)
{
    atomic_fetch_add_explicit(&m->ended[status], 1, memory_order_relaxed);
    observe(&m->job_seconds, seconds);
}

void metrics_moved(struct metrics *m, enum metrics_stage from, enum metrics_stage to, double seconds)
{
    if (from != STAGE_NONE) {
        observe(&m->stage_seconds[from], seconds);
        atomic_fetch_sub_explicit(&m->at_stage[from], 1, memory_order_relaxed);
    }
    if (to != STAGE_NONE)
        atomic_fetch_add_explicit(&m->at_stage[to], 1, memory_order_relaxed);
}

enum metrics_stage metrics_stage_of(const char *name)
{
    int i = 0;
    while (i < STAGE_OTHER && strcmp(name, stages[i]) != 0)
        i++;
    return (enum metrics_stage)i;
}

void metrics_refused(struct metrics *m, enum sga_code code)
{
    atomic_fetch_add_explicit(&m->refused[code], 1, memory_order_relaxed);
}

static void head(struct sga_buf *out, const char *name, const char *type, const char *help)
{
    int n = (int)strcspn(name, "{");
    sga_buf_printf(out, "# HELP sgad_%.*s %s\n# TYPE sgad_%.*s %s\n", n, name, help, n, name, type);
}

/* label: "" or `stage="x",`. */
static void write_series(const struct histogram *h, const char *name, const char *label, struct sga_buf *out)
{
    unsigned long count = 0;
    int n = (int)strlen(label) - (*label != 0);
    for (int i = 0; i < METRICS_BUCKETS; i++) {
        count += atomic_load(&h->bucket[i]);
        if (i < METRICS_BUCKETS - 1)
            sga_buf_printf(out, "sgad_%s_bucket{%sle=\"%g\"} %lu\n", name, label, bounds[i], count);
    }
    sga_buf_printf(out, "sgad_%s_bucket{%sle=\"+Inf\"} %lu\n", name, label, count);
    const char *open = n ? "{" : "", *close = n ? "}" : "";
    sga_buf_printf(out, "sgad_%s_sum%s%.*s%s %.6f\nsgad_%s_count%s%.*s%s %lu\n", name, open, n, label, close,
                   1e-6 * (double)atomic_load(&h->microseconds), name, open, n, label, close, count);
}

static void write_histogram(const struct histogram *h, const char *name, const char *help, struct sga_buf *out)
{
    head(out, name, "histogram", help);
    write_series(h, name, "", out);
}

static void write_stages(const struct metrics *m, struct sga_buf *out)
{
    char label[48];
    head(out, "jobs_at_stage", "gauge", "Jobs that have not ended, by stage");
    for (int i = 0; i < METRICS_STAGES; i++)
        sga_buf_printf(out, "sgad_jobs_at_stage{stage=\"%s\"} %lu\n", stages[i], atomic_load(&m->at_stage[i]));
    head(out, "stage_duration_seconds", "histogram", "How long jobs stay at each stage");
    for (int i = 0; i < METRICS_STAGES; i++) {
        snprintf(label, sizeof label, "stage=\"%s\",", stages[i]);
        write_series(&m->stage_seconds[i], "stage_duration_seconds", label, out);
    }
}

static void write_http(const struct metrics *m, const char *const *route_names, struct sga_buf *out)
{
    head(out, "http_requests_total", "counter", "Requests by route, method and status (0: any other)");
    for (int r = 0; r < METRICS_ROUTES && route_names[r]; r++)
        for (int k = 0; k < METRICS_METHODS; k++)
            for (int s = 0; s < METRICS_STATUSES; s++) {
                unsigned long n = atomic_load(&m->http[r][k][s]);
                if (n)
                    sga_buf_printf(out, "sgad_http_requests_total{route=\"%s\",method=\"%s\",status=\"%d\"} %lu\n",
                                   route_names[r], methods[k], statuses[s], n);
            }
}

static void gauge(struct sga_buf *out, const char *name, const char *help, unsigned long value)
{
    head(out, name, "gauge", help);
    sga_buf_printf(out, "sgad_%s %lu\n", name, value);
}

static void write_gauges(const struct metrics_now *now, struct sga_buf *out)
{
    head(out, "jobs", "gauge", "Jobs that have not ended, by state");
    sga_buf_printf(out, "sgad_jobs{status=\"queued\"} %lu\nsgad_jobs{status=\"running\"} %lu\n", now->queued, now->running);
    gauge(out, "queue_depth", "Jobs that wait for a worker", now->queued);
    gauge(out, "queue_bytes", "Bytes of the requests that wait", now->queue_bytes);
    head(out, "queue_oldest_seconds", "gauge", "How long the job that waits longest for a worker has waited");
    sga_buf_printf(out, "sgad_queue_oldest_seconds %.3f\n", now->oldest);
    gauge(out, "unsaved_jobs", "Jobs whose end is on its way to the disk", now->ending);
    gauge(out, "unsaved_bytes", "Bytes of their results", now->ending_bytes);
    gauge(out, "waiters", "Requests that wait for a job", now->waiters);
    gauge(out, "event_streams", "Open event streams", now->streams);
    gauge(out, "connections", "Open connections", now->connections);
    gauge(out, "store_healthy", "1 where the last write to the store succeeded", now->store_healthy);
    head(out, "state_free_bytes", "gauge", "Bytes that can still be written on the disk of the state");
    sga_buf_printf(out, "sgad_state_free_bytes %llu\n", now->free_bytes);
    head(out, "state_bytes", "gauge", "Bytes of the state's files on disk");
    sga_buf_printf(out, "sgad_state_bytes{file=\"queue\"} %llu\nsgad_state_bytes{file=\"results\"} %llu\n", now->queue_file, now->results_file);
    gauge(out, "reply_cache_bytes", "Bytes of finished replies in memory", now->reply_cache);
    head(out, "build_info", "gauge", "1, with the version of what runs");
    sga_buf_printf(out, "sgad_build_info{version=\"%s\"} 1\n", now->version);
    if (now->certificate_expires)
        gauge(out, "certificate_expiry_timestamp_seconds", "When the certificate ends, in seconds since 1970", now->certificate_expires);
    gauge(out, "ready", "1 where jobs are accepted", now->ready);
}

void metrics_write(const struct metrics *m, const struct metrics_now *now, const char *const *route_names, struct sga_buf *out)
{
    write_gauges(now, out);
    for (int i = 0; i < METRICS_COUNTERS_N; i++) {
        if (counters[i].help)
            head(out, counters[i].name, "counter", counters[i].help);
        sga_buf_printf(out, "sgad_%s %lu\n", counters[i].name, atomic_load(&m->counter[i]));
    }
    head(out, "log_dropped_total", "counter", "Log lines dropped because nobody read them fast enough");
    sga_buf_printf(out, "sgad_log_dropped_total %lu\n", now->log_dropped);
    head(out, "jobs_ended_total", "counter", "Jobs that ended, by their last state");
    for (int s = JOB_DONE; s < JOB_STATUSES; s++)
        sga_buf_printf(out, "sgad_jobs_ended_total{status=\"%s\"} %lu\n", job_status_text((enum job_status)s), atomic_load(&m->ended[s]));
    head(out, "refusals_total", "counter", "Requests refused, by code");
    for (int c = 1; c < SGA_E_COUNT; c++) {
        unsigned long n = atomic_load(&m->refused[c]);
        if (n)
            sga_buf_printf(out, "sgad_refusals_total{code=\"%s\"} %lu\n", sga_code_text((enum sga_code)c), n);
    }
    write_http(m, route_names, out);
    write_histogram(&m->request_seconds, "http_request_duration_seconds", "From the request line to the end of the reply", out);
    write_histogram(&m->job_seconds, "job_duration_seconds", "From the start of a job's run to its end", out);
    write_histogram(&m->commit_seconds, "store_commit_duration_seconds", "Transactions of the queue file, from begin to commit or failure", out);
    write_stages(m, out);
}
