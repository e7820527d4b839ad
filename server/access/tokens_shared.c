/* Tokens in the database that daemons share: a token that one of them is told of is everyone's. */
#include "postgres.h"
#include "tokens_place.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool bytes_of(const char *hex, unsigned char out[DIGEST_BYTES])
{
    unsigned byte;
    if (strlen(hex) != 2 * DIGEST_BYTES)
        return false;
    for (int i = 0; i < DIGEST_BYTES; i++) {
        if (sscanf(hex + 2 * i, "%2x", &byte) != 1)
            return false;
        out[i] = (unsigned char)byte;
    }
    return true;
}

struct reading { struct token_list *out; bool whole; };

static void read_one(void *ctx, const char *const column[10])
{
    struct reading *r = ctx;
    struct token *more = r->whole ? realloc(r->out->token, (r->out->count + 1) * sizeof *more) : NULL;
    if (!(r->whole = more))
        return;
    r->out->token = more;
    struct token *t = &more[r->out->count++];
    *t = (struct token){ .scopes = (unsigned)atol(column[2]), .created = atoll(column[3]), .expires = atoll(column[4]), .revoked = atoll(column[5]),
                         .quota = { atol(column[6]), atol(column[7]), atol(column[8]), atol(column[9]) } };
    snprintf(t->name, sizeof t->name, "%s", column[0]);
    if (!bytes_of(column[1], t->sum))
        t->revoked = 1;       /* no digest: it fits nobody */
}

bool tokens_shared_read(const char *address, struct token_list *out, char *why, size_t size)
{
    struct reading r = { out, true };
    *out = (struct token_list){ NULL, 0 };
    bool ok = postgres_tokens(address, read_one, &r, why, size);
    if (ok && r.whole)
        return true;
    if (ok)
        snprintf(why, size, "out of memory");
    free(out->token);
    *out = (struct token_list){ NULL, 0 };
    return false;
}

bool tokens_shared_add(const char *address, const struct token *t, char *why, size_t size)
{
    char hex[2 * DIGEST_BYTES + 1], number[8][32];
    const long long numbers[8] = { t->scopes, t->created, t->expires, 0, t->quota.jobs, t->quota.bytes, t->quota.waiters, t->quota.seconds };
    const char *column[10] = { t->name, hex };
    for (int i = 0; i < DIGEST_BYTES; i++)
        snprintf(hex + 2 * i, 3, "%02x", t->sum[i]);
    for (int i = 0; i < 8; i++) {
        snprintf(number[i], sizeof number[i], "%lld", numbers[i]);
        column[2 + i] = number[i];
    }
    bool done;
    if (!postgres_token_add(address, column, &done, why, size))
        return false;
    if (!done)
        snprintf(why, size, "there is a token called '%s' already; a name is used once, also after its token was revoked", t->name);
    return done;
}

bool tokens_shared_revoke(const char *address, const char *name, int64_t now, char *why, size_t size)
{
    bool done;
    if (!postgres_token_revoke(address, name, now, &done, why, size))
        return false;
    if (!done)
        snprintf(why, size, "there is no token called '%s' that is in force", name);
    return done;
}
