/* Finished replies kept in memory, and a way from the raw bytes of a body to them, so
 * that a repeated request is answered without reading its JSON. Thread-safe. */
#ifndef SERVER_MEMORY_CACHE_H
#define SERVER_MEMORY_CACHE_H

#include "finished.h"

struct memory_cache;

/* Keeps at most this many bytes of replies; the least recently used go first. A reply of
 * more than a quarter of the bytes is not kept. NULL when memory ends. */
struct memory_cache *memory_cache_new(size_t bytes);
void memory_cache_free(struct memory_cache *r);

/* With a reference for the caller, or NULL. */
struct finished *memory_cache_by_id(struct memory_cache *r, const char *id);
/* The reply to a body with this digest: only of a job that is done. */
struct finished *memory_cache_by_body(struct memory_cache *r, const unsigned char sum[DIGEST_BYTES]);

/* Bytes of the replies that it keeps. */
size_t memory_cache_bytes(struct memory_cache *r);
/* Takes a reference of its own; replaces what stood under the id. */
void memory_cache_put(struct memory_cache *r, struct finished *f);
void memory_cache_drop(struct memory_cache *r, const char *id);
/* This body asks for this job. Old pairs are forgotten. */
void memory_cache_alias(struct memory_cache *r, const unsigned char sum[DIGEST_BYTES], const char *id);

#endif
