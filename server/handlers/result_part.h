/* One member of a finished job's result, as a resource of its own. */
#ifndef SERVER_RESULT_PART_H
#define SERVER_RESULT_PART_H

#include "error.h"
#include "reply.h"

struct slice;

struct result_part_format {
    const char *name, *type;      /* of ?format= and of Accept; the first one is the default */
};

struct result_part_kind {
    const char *member;           /* of the result: an object */
    const char *list;             /* of the result: a list of them instead; or NULL */
    const struct result_part_format *format;
    int formats;                  /* at most RESULT_PART_FORMATS */
    const char *choices;          /* "json, csv or ndjson" */
    enum sga_code missing;        /* the result has none */
    const char *not_asked;        /* and then this is said */
};
enum { RESULT_PART_FORMATS = 6 };

/* The part of the job that the path names, with a reference to what holds it, and which format is
 * asked for; headers for caches are set. False: *rc is the reply, an error or 304. */
bool result_part_find(struct exchange *e, const struct result_part_kind *kind, struct finished **f, struct slice *part,
                      int *format, enum MHD_Result *rc);
/* The part as it stands in the result; the reference is consumed. */
enum MHD_Result result_part_send(struct exchange *e, struct finished *f, struct slice part);

#endif
