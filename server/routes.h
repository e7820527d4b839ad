/* The table of paths and what answers them. */
#ifndef SERVER_ROUTES_H
#define SERVER_ROUTES_H

#include "exchange.h"

typedef enum MHD_Result handler(struct exchange *e);

struct route {
    const char *pattern;      /* "*" is one segment of any text */
    unsigned scope;           /* of GET; POST and DELETE need `submit` */
    handler *get, *post, *remove;
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

handler handle_post_job, handle_solve;                               /* post.c */
handler handle_get_job, handle_list, handle_delete;                  /* get.c */
handler handle_events;                                               /* events.c */
handler handle_trajectory;                                           /* trajectory.c */
handler handle_tradeoff;                                             /* tradeoff.c */
handler handle_health, handle_ready, handle_metrics, handle_openapi, handle_schema, handle_version;   /* about.c */

#endif
