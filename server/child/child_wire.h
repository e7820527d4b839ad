/* Messages between a worker and its child process: a header, then so many bytes.
 * Both ends are the same program on the same machine, so the header is a plain struct. */
#ifndef SERVER_CHILD_WIRE_H
#define SERVER_CHILD_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum wire_type {
    WIRE_RUN = 'R',         /* to the child: a canonical request */
    WIRE_CHECK = 'Q',       /* to the child: a request to read and check; the canonical one is its WIRE_DONE */
    WIRE_REVIEW = 'V',      /* to the child: a request to read; its WIRE_DONE is all that there is to say of it (sga_review) */
    WIRE_CANCEL = 'C',      /* to the child: stop; empty */
    WIRE_PROGRESS = 'P',    /* from it: struct wire_progress */
    WIRE_PART = 'T',        /* from it: the next piece of the result's text */
    WIRE_DONE = 'D',        /* from it: the result's text, or what is left of it after pieces */
    WIRE_ERROR = 'E',       /* from it: struct sga_error */
    WIRE_READY = 'Y',       /* from it, once: it has confined itself and waits for requests; empty */
    WIRE_UNSAFE = 'U',      /* from it: why it could not confine itself; it ends with this */
    WIRE_LAST = 'L',        /* from it: struct sga_error, and it ends with this */
    /* Processes that make pieces of one loop together (lib/base/team.h): the child that runs the job leads, others help. */
    WIRE_SHARE = 'S',       /* from the leader: struct wire_share; is there help? */
    WIRE_HELP = 'H',        /* to a helper: struct wire_help, then the canonical request */
    WIRE_NEXT = 'N',        /* from either: which pieces? Empty */
    WIRE_PIECES = 'W',      /* to either: struct wire_pieces; of WIRE_SHARE: is it so, where to is not from */
    WIRE_MADE = 'M'         /* from a helper, and to the leader that asked for pieces: struct wire_pieces, then what they are */
};

struct wire_header {
    uint32_t type;
    uint32_t length;
    uint64_t resident;      /* from the child: the most memory it ever had, bytes */
};

struct wire_progress {
    char stage[32];
    double fraction;
    double t;               /* where a motion is; NAN: none is made */
};

struct wire_share {
    int32_t from, count;    /* pieces that may be given to others, of all */
    double spent, each;     /* seconds that the job has run for, and that one piece took */
};

struct wire_help {
    double spent;
};

struct wire_pieces {
    int32_t from, to;       /* from == to: none is left */
    int32_t made;           /* of all */
};

/* Blocking, whole. False: the other end is gone (or errno says). */
bool wire_send(int fd, enum wire_type type, uint64_t resident, const void *data, size_t length);
/* The same for data in two parts. */
bool wire_send_two(int fd, enum wire_type type, const void *head, size_t head_length, const void *data, size_t length);
bool wire_read(int fd, void *data, size_t length);

#endif
