/* Finished replies. The long text is copied once, between a written head and a brace. */
#include "finished.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool assemble(struct finished *f, const struct sga_buf *head, struct slice text)
{
    const char *member = !text.at ? "" : f->status == JOB_DONE ? ",\"result\":" : ",\"request\":";
    size_t n = strlen(member);
    f->head = head->len;
    f->len = head->len + n + text.len + 1;
    f->text = malloc(f->len + 1);
    if (!f->text)
        return false;
    char *p = f->text;
    memcpy(p, head->data, head->len);
    memcpy(p + head->len, member, n);
    p += head->len + n;
    if (text.at)
        memcpy(p, text.at, text.len);
    if (text.at && f->status == JOB_DONE)
        f->result = (struct slice){ p, text.len };
    memcpy(p + text.len, "}", 2);
    return true;
}

struct finished *finished_make(const struct job_row *row, struct slice text)
{
    struct finished *f = calloc(1, sizeof *f);
    if (!f)
        return NULL;
    atomic_init(&f->refs, 1);
    memcpy(f->id, row->id, sizeof f->id);
    f->status = row->status;
    snprintf(f->etag, sizeof f->etag, "\"%s-%" PRIx64 "\"", row->id, (uint64_t)row->finished);
    struct sga_buf head = { 0 };
    struct sga_json w;
    sga_json_begin(&w, &head);
    job_write_open(&w, row, NULL, &f->cached_at);
    bool ok = assemble(f, &head, text);
    sga_buf_free(&head);
    if (ok)
        return f;
    free(f);
    return NULL;
}

void finished_book(struct finished *f, atomic_long *bytes)
{
    f->booked = bytes;
    atomic_fetch_add(bytes, (long)f->len);
}

struct finished *finished_ref(struct finished *f)
{
    if (f)
        atomic_fetch_add(&f->refs, 1);
    return f;
}

void finished_unref(struct finished *f)
{
    if (f && atomic_fetch_sub(&f->refs, 1) == 1) {
        if (f->booked)
            atomic_fetch_sub(f->booked, (long)f->len);
        free(f->text);
        free(f);
    }
}
