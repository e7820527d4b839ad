/* Every call goes to the store at hand. */
#include "store_ops.h"
#include "finished.h"
#include "spool.h"

#include <stdlib.h>

void store_close(struct store *st)
{
    if (st)
        st->ops->close(st);
}

void store_limit(struct store *st, const atomic_long *cache_bytes) { st->ops->limit(st, cache_bytes); }
bool store_healthy(struct store *st) { return st->ops->healthy(st); }
unsigned long long store_free_bytes(struct store *st) { return st->ops->free_bytes(st); }
unsigned long long store_bytes(struct store *st, bool results) { return st->ops->bytes(st, results); }
void store_probe(struct store *st) { st->ops->probe(st); }
void store_look(struct store *st) { st->ops->look(st); }
void store_touch(struct store *st, const char *id, int64_t now) { st->ops->touch(st, id, now); }
bool store_shared(const struct store *st) { return st->ops->shared; }

bool store_submit(struct store *st, struct store_submission *s, store_done *done, void *ctx)
{
    return st->ops->submit(st, s, done, ctx);
}

bool store_end(struct store *st, const struct job_row *row, struct slice result, store_done *done, void *ctx)
{
    return st->ops->end(st, row, result, done, ctx);
}

bool store_release(struct store *st, const struct job_row *row, int64_t *next, store_done *done, void *ctx)
{
    return st->ops->release(st, row, next, done, ctx);
}

bool store_cancel(struct store *st, struct store_cancel *c, store_done *done, void *ctx) { return st->ops->cancel(st, c, done, ctx); }
bool store_join(struct store *st, const char *id, const char *owner) { return st->ops->join(st, id, owner); }
bool store_note(struct store *st, const char *id, const char *owner) { return st->ops->note(st, id, owner); }
bool store_withdraw(struct store *st, const char *id, const char *owner) { return st->ops->withdraw(st, id, owner); }
bool store_forget(struct store *st, const char *id) { return st->ops->forget(st, id); }
bool store_prune(struct store *st, const struct store_keep *keep) { return st->ops->prune(st, keep); }
bool store_barrier(struct store *st, store_done *done, void *ctx) { return st->ops->barrier(st, done, ctx); }

enum store_answer store_claim(struct store *st, const struct store_claimant *who, struct job_row *row, char **request, size_t *length)
{
    return st->ops->claim(st, who, row, request, length);
}

bool store_beat(struct store *st, const struct store_claimant *who, struct store_beat *beat, int count)
{
    return st->ops->beat(st, who, beat, count);
}

bool store_reap(struct store *st, struct store_reaping *r) { return st->ops->reap(st, r); }

enum store_answer store_look_at(struct store *st, const char *id, struct job_row *row, struct job_progress *progress)
{
    return st->ops->look_at(st, id, row, progress);
}

enum store_answer store_job(struct store *st, const char *id, struct job_row *row) { return st->ops->job(st, id, row); }

enum store_answer store_request(struct store *st, const char *id, char **text, size_t *length)
{
    return st->ops->request(st, id, text, length);
}

enum store_answer store_result(struct store *st, const char *id, char **text, size_t *length)
{
    return st->ops->result(st, id, text, length);
}

static void release(char *text)
{
    free(text);
}

enum store_answer store_finished(struct store *st, const char *id, const struct job_row *row, struct finished **out)
{
    char *text = NULL;
    size_t length = 0;
    bool done = row->status == JOB_DONE;
    enum store_answer a = (done ? store_result : store_request)(st, id, &text, &length);
    *out = NULL;
    if (a == STORE_FOUND)
        *out = done ? finished_take(row, &text, length) : finished_make(row, (struct slice){ text, length });
    (done ? spool_free : release)(text);
    return a == STORE_FOUND && !*out ? STORE_BROKEN : a;
}

bool store_owners(struct store *st, const char *id, void (*each)(void *ctx, const char *owner), void *ctx)
{
    return st->ops->owners(st, id, each, ctx);
}

enum store_answer store_owned(struct store *st, const char *id, const char *owner) { return st->ops->owned(st, id, owner); }

enum store_answer store_list(struct store *st, const struct store_query *q, struct store_page *page)
{
    return st->ops->list(st, q, page);
}

void store_page_free(struct store_page *page)
{
    for (int i = 0; i < page->rows; i++)
        free(page->row[i].error);
    free(page->row);
    *page = (struct store_page){ 0 };
}

bool store_started(struct store *st, const struct job_row *row) { return st->ops->started(st, row); }
int64_t store_epoch(struct store *st) { return st->ops->epoch(st); }

bool store_used(struct store *st, int64_t since, void (*each)(void *ctx, const char *owner, int64_t ms), void *ctx)
{
    return st->ops->used(st, since, each, ctx);
}

bool store_recover(struct store *st, void (*each)(void *ctx, const struct job_row *row), void *ctx, char *why, size_t size)
{
    return st->ops->recover(st, each, ctx, why, size);
}

void store_hint(struct store *st)
{
    if (st->ops->hint)
        st->ops->hint(st);
}

void store_listen(struct store *st, double seconds)
{
    if (st->ops->listen)
        st->ops->listen(st, seconds);
}
