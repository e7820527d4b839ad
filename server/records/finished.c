/* Finished replies. The long text stands between a written head and a brace. */
#include "finished.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"

/* Head, member and brace around the text, which lies at the front of f->text. */
static void assemble(struct finished *f, const struct sga_buf *head, const char *member, size_t length)
{
    size_t n = strlen(member);
    char *p = f->text + head->len + n;
    f->head = head->len;
    f->len = head->len + n + length + 1;
    memmove(p, f->text, length);
    memcpy(f->text, head->data, head->len);
    memcpy(f->text + head->len, member, n);
    if (*member && f->status == JOB_DONE)
        f->result = (struct slice){ p, length };
    memcpy(p + length, "}", 2);
}

/* text: NULL where it is not known. */
static struct finished *make(const struct job_row *row, char **text, size_t length)
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
    const char *member = !*text ? "" : f->status == JOB_DONE ? ",\"result\":" : ",\"request\":";
    f->text = realloc(*text, head.len + strlen(member) + length + 2);
    if (f->text) {
        *text = NULL;
        assemble(f, &head, member, length);
    } else {
        free(f);
        f = NULL;
    }
    sga_buf_free(&head);
    return f;
}

struct finished *finished_take(const struct job_row *row, char **text, size_t length)
{
    return make(row, text, *text ? length : 0);
}

struct finished *finished_make(const struct job_row *row, struct slice text)
{
    char *copy = text.at ? malloc(text.len + 1) : NULL;
    if (text.at && !copy)
        return NULL;
    if (text.at)
        memcpy(copy, text.at, text.len);
    struct finished *f = make(row, &copy, text.len);
    free(copy);
    return f;
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
