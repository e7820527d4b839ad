/* The job object. */
#include "job.h"
#include "buf.h"
#include "clock.h"

#include <stdio.h>
#include <string.h>

static const char *const names[JOB_STATUSES] = {
#define X(sym, text) [JOB_##sym] = text,
    JOB_STATUS_TABLE(X)
#undef X
};

const char *job_status_text(enum job_status status)
{
    return names[status];
}

enum job_status job_status_from_text(const char *text, size_t length)
{
    int i = 0;
    while (i < JOB_STATUSES && !(strlen(names[i]) == length && memcmp(names[i], text, length) == 0))
        i++;
    return (enum job_status)i;
}

static void write_time(struct sga_json *w, const char *key, int64_t ms)
{
    char text[CLOCK_TEXT];
    sga_json_key(w, key);
    if (!ms) {
        sga_json_null(w);
        return;
    }
    clock_text(text, ms);
    sga_json_string(w, text);
}

/* A name that was cut may end within a character, which is mended as problems are: left out. */
static void write_text(struct sga_json *w, const char *key, const char *text)
{
    char whole[sizeof ((struct job_row *)0)->name];
    size_t n = strlen(text), from = n;
    while (from && ((unsigned char)text[from - 1] & 0xc0) == 0x80)
        from--;
    unsigned char lead = from ? (unsigned char)text[from - 1] : 0;
    size_t needs = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : lead >= 0xc0 ? 2 : 1;
    if (from && n - (from - 1) < needs)
        n = from - 1;
    snprintf(whole, sizeof whole, "%.*s", (int)n, text);
    sga_json_key(w, key);
    if (n)
        sga_json_string(w, whole);
    else
        sga_json_null(w);
}

static void write_links(struct sga_json *w, const char *id)
{
    char path[ID_LENGTH + 32];
    sga_json_key(w, "links");
    sga_json_object(w);
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    sga_json_key(w, "self"), sga_json_string(w, path);
    snprintf(path, sizeof path, "/v1/jobs/%s/events", id);
    sga_json_key(w, "events"), sga_json_string(w, path);
    snprintf(path, sizeof path, "/v1/jobs/%s/request", id);
    sga_json_key(w, "request"), sga_json_string(w, path);
    snprintf(path, sizeof path, "/v1/jobs/%s/trajectory", id);
    sga_json_key(w, "trajectory"), sga_json_string(w, path);
    sga_json_end_object(w);
}

void job_write_open(struct sga_json *w, const struct job_row *row, const struct job_progress *progress, size_t *cached_at)
{
    sga_json_object(w);
    sga_json_key(w, "id"), sga_json_string(w, row->id);
    sga_json_key(w, "status"), sga_json_string(w, names[row->status]);
    if (row->listed) {
        write_text(w, "name", row->name);
        write_text(w, "form", row->form);
        write_text(w, "verdict", row->verdict);
    }
    sga_json_key(w, "cached");
    if (cached_at)
        *cached_at = w->out->len;
    sga_json_bool(w, false);
    sga_json_key(w, "progress");
    sga_json_object(w);
    sga_json_key(w, "stage"), sga_json_string(w, progress ? progress->stage : names[row->status]);
    sga_json_key(w, "fraction"), sga_json_double(w, progress ? progress->fraction : job_ended(row->status) ? 1 : 0);
    if (progress && progress->moves)
        sga_json_key(w, "t"), sga_json_double(w, progress->t);
    sga_json_end_object(w);
    write_time(w, "created", row->created);
    write_time(w, "started", row->started);
    write_time(w, "finished", row->finished);
    if (row->error) {
        sga_json_key(w, "error");
        sga_json_raw(w, row->error, strlen(row->error));
    }
    write_links(w, row->id);
}

void job_write(struct sga_json *w, const struct job_row *row, const struct job_progress *progress)
{
    job_write_open(w, row, progress, NULL);
    sga_json_end_object(w);
}
