/* What to say of a name whose index is not there. */
#include "names_family.h"

#include <stdio.h>
#include <string.h>

/* Bytes before the index. */
static size_t base_of(const char *name, size_t length)
{
    size_t n = 0;
    while (n < length && name[n] != '[' && name[n] != '\'')
        n++;
    return n;
}

bool names_family(const struct expr_store *st, const char *name, size_t length, char out[NAMES_FAMILY])
{
    size_t base = base_of(name, length);
    bool indexed = base < length && name[base] == '[', plain = false;
    const char *first = NULL, *last = NULL;
    int count = 0;
    for (int i = 0; i < st->symbols; i++) {
        const char *s = st->symbol[i].name;
        size_t n = strlen(s);
        if (n < base || memcmp(s, name, base) != 0 || s[n - (n > 0)] == '\'')
            continue;
        plain |= n == base;
        if (s[base] != '[')
            continue;
        first = first ? first : s;
        last = s;
        count++;
    }
    if (count == 1)
        snprintf(out, NAMES_FAMILY, "there is %.60s alone", first);
    else if (count)
        snprintf(out, NAMES_FAMILY, "there are %d, from %.60s to %.60s", count, first, last);
    else if (plain && indexed)
        snprintf(out, NAMES_FAMILY, "%.*s has no index", base > 60 ? 60 : (int)base, name);
    return count || (plain && indexed);
}
