/* Whole reads and writes on a stream socket. */
#include "child_wire.h"

#include <errno.h>
#include <sys/socket.h>

static bool write_all(int fd, const void *data, size_t length, int flags)
{
    const char *p = data;
    while (length) {
        ssize_t n = send(fd, p, length, MSG_NOSIGNAL | flags);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        p += n;
        length -= (size_t)n;
    }
    return true;
}

bool wire_send(int fd, enum wire_type type, uint64_t resident, const void *data, size_t length)
{
    struct wire_header h = { type, (uint32_t)length, resident };
    return length <= UINT32_MAX && write_all(fd, &h, sizeof h, length ? MSG_MORE : 0) && write_all(fd, data, length, 0);
}

bool wire_send_two(int fd, enum wire_type type, const void *head, size_t head_length, const void *data, size_t length)
{
    struct wire_header h = { type, (uint32_t)(head_length + length), 0 };
    return head_length + length <= UINT32_MAX && write_all(fd, &h, sizeof h, MSG_MORE) && write_all(fd, head, head_length, length ? MSG_MORE : 0)
        && write_all(fd, data, length, 0);
}

bool wire_read(int fd, void *data, size_t length)
{
    char *p = data;
    while (length) {
        ssize_t n = recv(fd, p, length, 0);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        p += n;
        length -= (size_t)n;
    }
    return true;
}
