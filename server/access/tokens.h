/* Tokens: who may ask, and for what. A token is "sgad_" and 64 hexadecimal digits (256 random
 * bits); what is kept is its SHA-256, in tokens.db of the state folder, so that neither the
 * file nor a backup lets anyone in. The daemon holds the table in memory. */
#ifndef SERVER_TOKENS_H
#define SERVER_TOKENS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "digest.h"
#include "quota.h"

/* SCOPE_WATCH: /metrics, which those with `read` have too. */
enum scope { SCOPE_SUBMIT = 1, SCOPE_READ = 2, SCOPE_ADMIN = 4, SCOPE_WATCH = 8, SCOPE_ALL = 15 };

struct token {
    char name[ACCOUNT_NAME];
    unsigned char sum[DIGEST_BYTES];
    unsigned scopes;
    int64_t created, expires, revoked;     /* seconds since 1970; 0: never */
    struct quota quota;
    struct account *account;               /* in the daemon only */
};

/* "submit,read" as a set; 0 where it names something else. */
unsigned scopes_read(const char *text);
/* The opposite, into out. */
void scopes_write(unsigned scopes, char *out, size_t size);

/* -- The file (tokens_file.c) -- */

struct token_list { struct token *token; size_t count; };

/* `folder` is that of the state, or the address of a database that daemons share. */

/* All tokens, oldest first; a missing file holds none. False with a reason in why. */
bool tokens_read(const char *folder, struct token_list *out, char *why, size_t size);
/* Makes the folder and the file where they are missing. A name is used once. */
bool tokens_add(const char *folder, const struct token *t, char *why, size_t size);
bool tokens_revoke(const char *folder, const char *name, int64_t now, char *why, size_t size);

/* -- The table of the daemon (tokens.c) -- */

struct tokens;
struct jobs;

struct tokens *tokens_new(const char *folder, struct jobs *jobs);
void tokens_free(struct tokens *ts);
/* Reads the file again if it changed (always: in any case; only then a database is asked). False: it could not be read, and
 * what was known before stands. Any thread. */
bool tokens_refresh(struct tokens *ts, bool always, char *why, size_t size);
/* The token of this text, unless it is expired or revoked. */
bool tokens_find(struct tokens *ts, const char *text, struct token *out);

#endif
