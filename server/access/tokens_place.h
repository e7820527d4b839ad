/* Where tokens are kept besides the file: internal to access. */
#ifndef SERVER_TOKENS_PLACE_H
#define SERVER_TOKENS_PLACE_H

#include "tokens.h"

/* As tokens_read, tokens_add and tokens_revoke, of a database. */
bool tokens_shared_read(const char *address, struct token_list *out, char *why, size_t size);
bool tokens_shared_add(const char *address, const struct token *t, char *why, size_t size);
bool tokens_shared_revoke(const char *address, const char *name, int64_t now, char *why, size_t size);

#endif
