/* A store that several daemons share, on one machine or on many: a database of PostgreSQL.
 *
 * The database owns the queue, the ends, the results, the tokens and the clock of leases. A daemon
 * owns its connections, its waiters, its processes and its memory of answers. What is committed is
 * durable as far as the server makes it so: over the loss of a server only with a synchronous
 * standby, and the start warns where there is none.
 *
 * A database that is away costs no thread more than one statement's time: from the first failure on
 * every call fails at once, until the thread that looks after the connections has one again. */
#ifndef SERVER_POSTGRES_H
#define SERVER_POSTGRES_H

#include <stdbool.h>
#include <stddef.h>

#include "store.h"

/* Is this the address of a database (postgresql://...)? */
bool postgres_address(const char *place);
/* Connects, looks whether the schema is one that this program speaks. `version` of the library:
 * borrowed. NULL with a reason in why; so where the program was built without libpq. */
struct store *postgres_open(const char *address, const char *version, struct metrics *m, char *why, size_t size);
/* Brings the schema up to date, one step a transaction, under a lock that all who migrate take.
 * *from and *to: the schema before and after. */
bool postgres_migrate(const char *address, int *from, int *to, char *why, size_t size);

/* -- Tokens: see access/tokens.h -- */

/* A row of text for each token, by the columns of the table tokens, each NULL-terminated list of 10;
 * sum in hexadecimal. False with a reason in why. */
bool postgres_tokens(const char *address, void (*each)(void *ctx, const char *const column[10]), void *ctx, char *why, size_t size);
/* *done: false where the name is taken, or there is none to revoke. */
bool postgres_token_add(const char *address, const char *const column[10], bool *done, char *why, size_t size);
bool postgres_token_revoke(const char *address, const char *name, long long now, bool *done, char *why, size_t size);

#endif
