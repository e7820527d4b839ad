/* Finished replies kept in memory, and a way from the raw bytes of a body to them, so
 * that a repeated request is answered without reading its JSON. Thread-safe. */
#ifndef SERVER_RECENT_H
#define SERVER_RECENT_H

#include "digest.h"
#include "finished.h"

struct recent;

/* Keeps at most this many bytes of replies; the least recently used go first. A reply of
 * more than a quarter of the bytes is not kept. NULL when memory ends. */
struct recent *recent_new(size_t bytes);
void recent_free(struct recent *r);

/* With a reference for the caller, or NULL. */
struct finished *recent_by_id(struct recent *r, const char *id);
/* The reply to a body with this digest: only of a job that is done. */
struct finished *recent_by_body(struct recent *r, const unsigned char sum[DIGEST_BYTES]);

/* Takes a reference of its own; replaces what stood under the id. */
void recent_put(struct recent *r, struct finished *f);
void recent_drop(struct recent *r, const char *id);
/* This body asks for this job. Old pairs are forgotten. */
void recent_alias(struct recent *r, const unsigned char sum[DIGEST_BYTES], const char *id);

#endif
