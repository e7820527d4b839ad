/* Files of schema/, put into the program when it is built (embed.sh). */
#ifndef SERVER_EMBED_H
#define SERVER_EMBED_H

#include <stddef.h>

struct embedded {
    const char *name;      /* "openapi", "request", ... */
    const char *text;
    size_t length;
};

extern const struct embedded embedded_files[];     /* ended by a NULL name */

const struct embedded *embedded_find(const char *name, size_t length);

#endif
