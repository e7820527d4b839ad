/* Looking up embedded files: "request" and "request.json" name the same one. */
#include "embed.h"

#include <string.h>

const struct embedded *embedded_find(const char *name, size_t length)
{
    if (length > 5 && memcmp(name + length - 5, ".json", 5) == 0)
        length -= 5;
    for (const struct embedded *f = embedded_files; f->name; f++)
        if (strlen(f->name) == length && memcmp(f->name, name, length) == 0)
            return f;
    return NULL;
}
