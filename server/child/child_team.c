/* What the library asks of the other processes of a job, as messages to the worker. */
#include "child_team.h"
#include "child_wire.h"

#include <stdlib.h>
#include <unistd.h>

/* The next header; false where it is a cancellation. A worker that is gone ends the process. */
static bool answered(struct child_team *t, struct wire_header *h)
{
    if (!wire_read(t->fd, h, sizeof *h))
        _exit(0);
    *t->cancelled |= h->type == WIRE_CANCEL;
    return h->type != WIRE_CANCEL;
}

static bool read_pieces(struct child_team *t, const struct wire_header *h, struct wire_pieces *p)
{
    return h->length >= sizeof *p && wire_read(t->fd, p, sizeof *p);
}

static bool share(void *ctx, int from, int count, double spent, double each)
{
    struct child_team *t = ctx;
    struct wire_share s = { from, count, spent, each };
    struct wire_header h;
    struct wire_pieces p;
    return wire_send(t->fd, WIRE_SHARE, 0, &s, sizeof s) && answered(t, &h) && h.type == WIRE_PIECES && read_pieces(t, &h, &p) && p.from < p.to;
}

/* What another process made, for the library. */
static bool take_made(struct child_team *t, const struct wire_header *h)
{
    struct wire_pieces p;
    if (!read_pieces(t, h, &p))
        return false;
    size_t length = h->length - sizeof p;
    char *data = malloc(length + 1);
    bool ok = data && wire_read(t->fd, data, length) && t->team.take(t->team.of, p.from, p.to, data, length);
    free(data);
    return ok;
}

static bool next(void *ctx, int *from, int *to, int *made)
{
    struct child_team *t = ctx;
    struct wire_header h;
    struct wire_pieces p;
    if (!wire_send(t->fd, WIRE_NEXT, 0, NULL, 0))
        return false;
    do
        if (!answered(t, &h))
            return false;
    while (h.type == WIRE_MADE && t->team.take && take_made(t, &h));
    if (h.type != WIRE_PIECES || !read_pieces(t, &h, &p))
        return false;
    *from = p.from;
    *to = p.to;
    *made = p.made;
    return p.from < p.to;
}

static bool give(void *ctx, int from, int to, const char *data, size_t length)
{
    struct child_team *t = ctx;
    struct wire_pieces p = { from, to, 0 };
    return wire_send_two(t->fd, WIRE_MADE, &p, sizeof p, data, length);
}

void child_team_begin(struct child_team *t, int fd, bool *cancelled)
{
    *t = (struct child_team){ .team = { .ctx = t, .share = share, .next = next, .give = give }, .fd = fd, .cancelled = cancelled };
}
