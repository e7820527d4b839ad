/* A message from a child process, as far as it has come. */
#ifndef SERVER_CHILD_INBOX_H
#define SERVER_CHILD_INBOX_H

#include "child_wire.h"

struct sga_error;

struct child_inbox {
    struct wire_header head;
    size_t head_len, len;
    char *data;                      /* head.length bytes and a 0; owned */
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
/* The error in a message: trusted no further than its size. */
void child_error(const struct child_inbox *in, struct sga_error *err);
void child_inbox_clear(struct child_inbox *in);

#endif
