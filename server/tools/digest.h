/* SHA-256 and the ids made of it: the same request is the same job. */
#ifndef SERVER_DIGEST_H
#define SERVER_DIGEST_H

#include <gnutls/crypto.h>
#include <stdbool.h>
#include <stddef.h>

enum { DIGEST_BYTES = 32, ID_LENGTH = 32 };   /* bytes; hexadecimal digits */

void digest(unsigned char out[DIGEST_BYTES], const void *data, size_t length);
/* Of a text that is kept under an id: SHA-256(id, newline, text). What it has gone through rests (spool.h). */
void digest_kept(unsigned char out[DIGEST_BYTES], const char *id, const void *text, size_t length);
/* The same of a text in pieces, in their order. */
struct digest_run { gnutls_hash_hd_t hash; };
void digest_begin(struct digest_run *d, const char *id);
void digest_add(struct digest_run *d, const void *piece, size_t length);
void digest_end(struct digest_run *d, unsigned char out[DIGEST_BYTES]);
/* The id of a canonical request under a version of the library: the first 128 bits
 * of SHA-256(version, newline, request) in hexadecimal, 0-terminated. */
void digest_id(char out[ID_LENGTH + 1], const char *version, const char *request, size_t length);
/* Has this text the form of an id? */
bool digest_is_id(const char *text, size_t length);

#endif
