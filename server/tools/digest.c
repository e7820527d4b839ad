/* SHA-256 by GnuTLS. */
#include "digest.h"
#include "no_memory.h"
#include "spool.h"

#include <gnutls/crypto.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* GnuTLS takes memory for a digest, and fails for want of it alone. */

void digest(unsigned char out[DIGEST_BYTES], const void *data, size_t length)
{
    if (gnutls_hash_fast(GNUTLS_DIG_SHA256, data, length, out) != 0)
        no_memory("a digest");
}

void digest_begin(struct digest_run *d, const char *first)
{
    if (gnutls_hash_init(&d->hash, GNUTLS_DIG_SHA256) != 0)
        no_memory("a digest");
    gnutls_hash(d->hash, first, strlen(first));
    gnutls_hash(d->hash, "\n", 1);
}

void digest_add(struct digest_run *d, const void *text, size_t length)
{
    const char *at = text;
    for (size_t n; length; at += n, length -= n) {
        n = length < SPOOL_STEP ? length : SPOOL_STEP;
        gnutls_hash(d->hash, at, n);
        if (n == SPOOL_STEP)
            spool_rest(at, n);
    }
}

void digest_end(struct digest_run *d, unsigned char out[DIGEST_BYTES])
{
    gnutls_hash_deinit(d->hash, out);
}

/* SHA-256(first, newline, text) */
static void pair(unsigned char out[DIGEST_BYTES], const char *first, const void *text, size_t length)
{
    struct digest_run d;
    digest_begin(&d, first);
    digest_add(&d, text, length);
    digest_end(&d, out);
}

void digest_kept(unsigned char out[DIGEST_BYTES], const char *id, const void *text, size_t length)
{
    pair(out, id, text, length);
}

void digest_id(char out[ID_LENGTH + 1], const char *version, const char *request, size_t length)
{
    static const char hex[] = "0123456789abcdef";
    unsigned char sum[DIGEST_BYTES];
    pair(sum, version, request, length);
    for (int i = 0; i < ID_LENGTH / 2; i++) {
        out[2 * i] = hex[sum[i] >> 4];
        out[2 * i + 1] = hex[sum[i] & 15];
    }
    out[ID_LENGTH] = 0;
}

bool digest_is_id(const char *text, size_t length)
{
    return length == ID_LENGTH && strspn(text, "0123456789abcdef") >= length;
}
