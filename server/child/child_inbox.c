/* Reading messages piece by piece. */
#include "child_inbox.h"
#include "budget.h"
#include "error.h"
#include "spool.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

enum received child_receive(struct child_inbox *in, int fd, size_t limit)
{
    if (in->head_len < sizeof in->head) {
        ssize_t n = recv(fd, (char *)&in->head + in->head_len, sizeof in->head - in->head_len, MSG_DONTWAIT);
        if (n <= 0)
            return n < 0 && (errno == EAGAIN || errno == EINTR) ? RECEIVED_PART : RECEIVED_END;
        in->head_len += (size_t)n;
        if (in->head_len < sizeof in->head)
            return RECEIVED_PART;
        if (in->head.length > limit || !(in->data = spool_new(in->head.length)))
            return RECEIVED_TOO_LARGE;
        in->data[in->head.length] = 0;
        in->len = in->rested = 0;
    }
    while (in->len < in->head.length) {
        ssize_t n = recv(fd, in->data + in->len, in->head.length - in->len, MSG_DONTWAIT);
        if (n <= 0)
            return n < 0 && (errno == EAGAIN || errno == EINTR) ? RECEIVED_PART : RECEIVED_END;
        in->len += (size_t)n;
        if (in->len - in->rested >= SPOOL_STEP) {
            spool_rest(in->data + in->rested, in->len - in->rested);
            in->rested = in->len;
        }
    }
    return RECEIVED_WHOLE;
}

void child_inbox_clear(struct child_inbox *in)
{
    spool_free(in->data);
    *in = (struct child_inbox){ 0 };
}

enum received child_receive_until(struct child_inbox *in, int fd, size_t limit, double deadline)
{
    enum received r;
    double left;
    while ((r = child_receive(in, fd, limit)) == RECEIVED_PART && (left = deadline - sga_now()) > 0) {
        struct pollfd p = { .fd = fd, .events = POLLIN };
        poll(&p, 1, left > 3600 ? 3600000 : (int)(left * 1000) + 1);
    }
    return r;
}

bool child_parts_add(struct child_parts *p, const struct child_inbox *in)
{
    size_t length = p->len + in->head.length;
    if (length > p->room || !p->text) {
        size_t room = p->text ? 2 * length : 4 * SPOOL_LONG;
        char *more = p->text ? spool_resize(p->text, room) : spool_new(room);
        if (!more)
            return false;
        p->text = more;
        p->room = room;
    }
    memcpy(p->text + p->len, in->data, in->head.length);
    spool_rest(p->text + p->len, in->head.length);
    p->len = length;
    p->text[length] = 0;
    return true;
}

bool child_parts_end(struct child_parts *p, struct child_inbox *in)
{
    if (!p->text)
        return true;
    if (!child_parts_add(p, in))
        return false;
    spool_free(in->data);
    in->data = p->text;
    in->len = in->rested = p->len;
    in->head.length = (uint32_t)p->len;
    *p = (struct child_parts){ 0 };
    return true;
}

void child_parts_clear(struct child_parts *p)
{
    spool_free(p->text);
    *p = (struct child_parts){ 0 };
}

void child_error(const struct child_inbox *in, struct sga_error *err)
{
    *err = (struct sga_error){ .code = SGA_E_INTERNAL, .stage = "worker", .detail = "The process that ran the job gave a malformed error." };
    if (in->head.length != sizeof *err)
        return;
    memcpy(err, in->data, sizeof *err);
    err->detail[sizeof err->detail - 1] = err->pointer[sizeof err->pointer - 1] = err->stage[sizeof err->stage - 1] = 0;
    if (err->code <= SGA_E_OK || err->code >= SGA_E_COUNT)
        err->code = SGA_E_INTERNAL;
}
