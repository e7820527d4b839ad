/* Finished replies. The long text stands between a written head and a brace. */
#include "finished.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "spool.h"

/* So many bytes before the text and a brace behind it: around it where it is, unless there is not so much room before it. */
static bool make_room(struct finished *f, char **text, size_t length, size_t before)
{
    bool around = *text && before <= SPOOL_HEAD;
    f->block = around ? spool_resize(*text, length + 1) : spool_new(before + length + 1);
    if (!f->block)
        return false;
    spool_settle(f->block);
    f->text = around ? f->block - before : f->block;
    if (!around && *text) {
        memcpy(f->text + before, *text, length);
        spool_free(*text);
    }
    *text = NULL;
    return true;
}

static void assemble(struct finished *f, const struct sga_buf *head, const char *member, size_t length)
{
    size_t n = strlen(member);
    char *text = f->text + head->len + n;
    f->head = head->len;
    f->len = head->len + n + length + 1;
    memcpy(f->text, head->data, head->len);
    memcpy(f->text + head->len, member, n);
    if (*member && f->status == JOB_DONE)
        f->result = (struct slice){ text, length };
    memcpy(text + length, "}", 2);
}

/* text: of spool_new, taken over; NULL where it is not known. */
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
    if (make_room(f, text, length, head.len + strlen(member))) {
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
    char *copy = text.at ? spool_new(text.len) : NULL;
    if (text.at && !copy)
        return NULL;
    if (text.at)
        memcpy(copy, text.at, text.len);
    struct finished *f = make(row, &copy, text.len);
    spool_free(copy);
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
        spool_free(f->block);
        free(f);
    }
}
