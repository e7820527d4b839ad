/* The table of paths and what answers them. */
#ifndef SERVER_ROUTES_H
#define SERVER_ROUTES_H

#include <stddef.h>

#include "handlers.h"

struct route {
    const char *pattern;      /* "*" is one segment of any text */
    unsigned scope;           /* of GET; POST and DELETE need `submit` */
    handler *get, *post, *remove;
    const char *query;        /* parameters that it knows, with blanks between */
};

/* The route of a path, with the text of its "*" in segment[size]; NULL: none. */
const struct route *route_find(const char *path, char *segment, size_t size);
/* HEAD is answered as GET; NULL: not allowed. */
handler *route_handler(const struct route *r, const char *method);
/* The scope that a caller needs; 0: none. */
unsigned route_scope(const struct route *r, const char *method);
/* "GET, HEAD, DELETE" into out. */
void route_allow(const struct route *r, char *out, size_t size);
int route_number(const struct route *r);              /* NULL: the number of "other" */
extern const char *const route_names[];               /* by number, NULL at the end */

#endif
