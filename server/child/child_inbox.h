/* A message from a child process, as far as it has come. */
#ifndef SERVER_CHILD_INBOX_H
#define SERVER_CHILD_INBOX_H

#include "child_wire.h"

struct sga_error;

struct child_inbox {
    struct wire_header head;
    size_t head_len, len;
    size_t rested;                   /* bytes of data that are not looked at any more (spool_rest) */
    char *data;                      /* head.length bytes and a 0; of spool_new; owned */
};

enum received {
    RECEIVED_PART,                   /* more is to come */
    RECEIVED_WHOLE,
    RECEIVED_END,                    /* the other end is gone */
    RECEIVED_TOO_LARGE               /* longer than the limit (head.length says how long), or than memory */
};

/* Takes what there is, without waiting. */
enum received child_receive(struct child_inbox *in, int fd, size_t limit);
/* Waits until the deadline (sga_now()); past it RECEIVED_PART. */
enum received child_receive_until(struct child_inbox *in, int fd, size_t limit, double deadline);
/* A result that comes in pieces, as far as it has come. */
struct child_parts {
    char *text;                      /* of spool_new, with room for so many bytes; NULL: none came */
    size_t len, room;
};
/* One more piece (WIRE_PART). False: memory ended. */
bool child_parts_add(struct child_parts *p, const struct child_inbox *in);
/* The last message (WIRE_DONE): now it has all of the text, which p gives up. False: memory ended. */
bool child_parts_end(struct child_parts *p, struct child_inbox *in);
void child_parts_clear(struct child_parts *p);
/* The error in a message: trusted no further than its size. */
void child_error(const struct child_inbox *in, struct sga_error *err);
void child_inbox_clear(struct child_inbox *in);

#endif
