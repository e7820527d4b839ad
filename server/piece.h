/* One member of a finished job's result, as a resource of its own. */
#ifndef SERVER_PIECE_H
#define SERVER_PIECE_H

#include "finished.h"
#include "lookup.h"
#include "reply.h"
#include "scan.h"

struct piece_format {
    const char *name, *type;      /* of ?format= and of Accept; the first one is the default */
};

struct piece_kind {
    const char *member;           /* of the result: an object */
    const char *list;             /* of the result: a list of them instead; or NULL */
    const struct piece_format *format;
    int formats;                  /* at most PIECE_FORMATS */
    const char *choices;          /* "json, csv or ndjson" */
    enum sga_code missing;        /* the result has none */
    const char *not_asked;        /* and then this is said */
};
enum { PIECE_FORMATS = 4 };

/* The piece of the job that the path names, with a reference to what holds it, and which format is
 * asked for; headers for caches are set. False: *rc is the reply, an error or 304. */
bool piece_find(struct exchange *e, const struct piece_kind *kind, struct finished **f, struct slice *piece, int *format, enum MHD_Result *rc);
/* The piece as it stands in the result; the reference is consumed. */
enum MHD_Result piece_send(struct exchange *e, struct finished *f, struct slice piece);

#endif
