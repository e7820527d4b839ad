/* Inside written*.c only: what was written out, and from where. */
#ifndef SGA_REQUEST_WRITTEN_PIECE_H
#define SGA_REQUEST_WRITTEN_PIECE_H

#include "index.h"

/* Elements start .. start + count - 1 of a list, or members of an object (start -1). The texts are the reader's. */
struct piece {
    const char *list;             /* pointer of the list or object */
    const char *text;             /* the loop, or the name with ranges */
    const char *body;             /* the loop's body; NULL: the name itself */
    const char *member;           /* of the body: "equation", "expression", or NULL */
    long start, count, index;     /* index: of the element that it came from, -1: no list around it */
};
struct written {
    struct index_scope sizes;
    struct piece *piece; size_t pieces, cap;
    long elements; size_t bytes;  /* of all that was made */
};

#endif
