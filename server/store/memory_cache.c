/* An LRU list over chained buckets; aliases are a direct-mapped table, since to forget
 * one costs a parse and nothing else.
 *
 * Invariants under the lock: every entry is in its bucket and in the list; bytes is the
 * sum over the list. */
#include "memory_cache.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { BUCKETS = 4096, ALIASES = 8192, ENTRY_COST = 512 };

struct entry {
    struct finished *f;
    struct entry *chain, *newer, *older;
};

struct alias {
    unsigned char sum[DIGEST_BYTES];
    char id[ID_LENGTH + 1];      /* empty: unused */
};

struct memory_cache {
    pthread_mutex_t lock;
    size_t bytes, max_bytes;
    struct entry *newest, *oldest;
    struct entry *bucket[BUCKETS];
    struct alias alias[ALIASES];
};

struct memory_cache *memory_cache_new(size_t bytes)
{
    struct memory_cache *r = calloc(1, sizeof *r);
    if (!r)
        return NULL;
    pthread_mutex_init(&r->lock, NULL);
    r->max_bytes = bytes;
    return r;
}

/* The entry's place in its bucket, or where it would be appended. */
static struct entry **place(struct memory_cache *r, const char *id)
{
    unsigned h = 2166136261u;
    for (int i = 0; i < ID_LENGTH; i++)
        h = (h ^ (unsigned char)id[i]) * 16777619u;
    struct entry **e = &r->bucket[h % BUCKETS];
    while (*e && memcmp((*e)->f->id, id, ID_LENGTH) != 0)
        e = &(*e)->chain;
    return e;
}

static void unlink_entry(struct memory_cache *r, struct entry *e)
{
    *(e->newer ? &e->newer->older : &r->newest) = e->older;
    *(e->older ? &e->older->newer : &r->oldest) = e->newer;
}

static void link_newest(struct memory_cache *r, struct entry *e)
{
    assert(r->newest != e && !r->newest == !r->oldest);
    e->newer = NULL;
    e->older = r->newest;
    *(r->newest ? &r->newest->newer : &r->oldest) = e;
    r->newest = e;
}

static size_t cost(const struct finished *f)
{
    return f->len + ENTRY_COST;
}

static void remove_entry(struct memory_cache *r, struct entry **at)
{
    struct entry *e = *at;
    *at = e->chain;
    assert(r->bytes >= cost(e->f));
    unlink_entry(r, e);
    r->bytes -= cost(e->f);
    finished_unref(e->f);
    free(e);
}

static struct finished *get(struct memory_cache *r, const char *id)
{
    struct entry *e = *place(r, id);
    if (!e)
        return NULL;
    if (r->newest != e) {
        unlink_entry(r, e);
        link_newest(r, e);
    }
    return finished_ref(e->f);
}

struct finished *memory_cache_by_id(struct memory_cache *r, const char *id)
{
    pthread_mutex_lock(&r->lock);
    struct finished *f = get(r, id);
    pthread_mutex_unlock(&r->lock);
    return f;
}

static struct alias *alias_of(struct memory_cache *r, const unsigned char *sum)
{
    return &r->alias[(sum[0] | (unsigned)sum[1] << 8) % ALIASES];
}

struct finished *memory_cache_by_body(struct memory_cache *r, const unsigned char sum[DIGEST_BYTES])
{
    pthread_mutex_lock(&r->lock);
    struct alias *a = alias_of(r, sum);
    struct finished *f = *a->id && memcmp(a->sum, sum, DIGEST_BYTES) == 0 ? get(r, a->id) : NULL;
    pthread_mutex_unlock(&r->lock);
    if (f && f->status != JOB_DONE) {
        finished_unref(f);
        return NULL;
    }
    return f;
}

void memory_cache_alias(struct memory_cache *r, const unsigned char sum[DIGEST_BYTES], const char *id)
{
    pthread_mutex_lock(&r->lock);
    struct alias *a = alias_of(r, sum);
    memcpy(a->sum, sum, DIGEST_BYTES);
    memcpy(a->id, id, sizeof a->id);
    pthread_mutex_unlock(&r->lock);
}

size_t memory_cache_bytes(struct memory_cache *r)
{
    pthread_mutex_lock(&r->lock);
    size_t bytes = r->bytes;
    pthread_mutex_unlock(&r->lock);
    return bytes;
}

void memory_cache_put(struct memory_cache *r, struct finished *f)
{
    if (cost(f) > r->max_bytes / 4)
        return;
    struct entry *fresh = calloc(1, sizeof *fresh);
    if (!fresh)
        return;      /* a reply that is not kept is read from the store */
    fresh->f = finished_ref(f);
    pthread_mutex_lock(&r->lock);
    struct entry **at = place(r, f->id);
    if (*at)
        remove_entry(r, at);
    at = place(r, f->id);
    *at = fresh;
    link_newest(r, fresh);
    r->bytes += cost(f);
    while (r->bytes > r->max_bytes)
        remove_entry(r, place(r, r->oldest->f->id));
    pthread_mutex_unlock(&r->lock);
}

void memory_cache_drop(struct memory_cache *r, const char *id)
{
    pthread_mutex_lock(&r->lock);
    struct entry **at = place(r, id);
    if (*at)
        remove_entry(r, at);
    pthread_mutex_unlock(&r->lock);
}

void memory_cache_free(struct memory_cache *r)
{
    if (!r)
        return;
    while (r->oldest)
        remove_entry(r, place(r, r->oldest->f->id));
    assert(r->bytes == 0 && !r->newest);
    pthread_mutex_destroy(&r->lock);
    free(r);
}
