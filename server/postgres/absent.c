/* A program that was built without libpq. */
#include "postgres.h"

#include <stdio.h>
#include <string.h>

static bool absent(char *why, size_t size)
{
    snprintf(why, size, "this sgad was built without PostgreSQL: install libpq-dev and build it anew");
    return false;
}

bool postgres_address(const char *place)
{
    return strncmp(place, "postgresql://", 13) == 0 || strncmp(place, "postgres://", 11) == 0;
}

struct store *postgres_open(const char *address, const char *version, struct metrics *m, char *why, size_t size)
{
    (void)address, (void)version, (void)m;
    absent(why, size);
    return NULL;
}

bool postgres_migrate(const char *address, int *from, int *to, char *why, size_t size)
{
    (void)address;
    *from = *to = 0;
    return absent(why, size);
}

bool postgres_tokens(const char *address, void (*each)(void *ctx, const char *const column[10]), void *ctx, char *why, size_t size)
{
    (void)address, (void)each, (void)ctx;
    return absent(why, size);
}

bool postgres_token_add(const char *address, const char *const column[10], bool *done, char *why, size_t size)
{
    (void)address, (void)column;
    *done = false;
    return absent(why, size);
}

bool postgres_token_revoke(const char *address, const char *name, long long now, bool *done, char *why, size_t size)
{
    (void)address, (void)name, (void)now;
    *done = false;
    return absent(why, size);
}
