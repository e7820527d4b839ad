/* One datagram for each message. */
#include "notify.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

/* False: there is nobody to tell, or the name is none. A name that begins with @ is abstract. */
static bool address(struct sockaddr_un *a, socklen_t *length)
{
    const char *name = getenv("NOTIFY_SOCKET");
    size_t n = name ? strlen(name) : 0;
    *a = (struct sockaddr_un){ .sun_family = AF_UNIX };
    if (n < 2 || n >= sizeof a->sun_path || (*name != '/' && *name != '@'))
        return false;
    memcpy(a->sun_path, name, n);
    if (*name == '@')
        *a->sun_path = 0;
    *length = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + n);
    return true;
}

void notify(const char *fmt, ...)
{
    struct sockaddr_un a;
    socklen_t length;
    char text[512];
    if (!address(&a, &length))
        return;
    va_list ap;
    va_start(ap, fmt);
    int n = vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return;
    if (n > 0)
        sendto(fd, text, strlen(text), MSG_NOSIGNAL, (const struct sockaddr *)&a, length);
    close(fd);
}

double notify_watchdog(void)
{
    const char *usec = getenv("WATCHDOG_USEC"), *pid = getenv("WATCHDOG_PID");
    if (!usec || (pid && strtol(pid, NULL, 10) != (long)getpid()))
        return 0;
    double half = 0.5e-6 * strtod(usec, NULL);
    return half > 0 ? half : 0;
}

unsigned long long notify_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (unsigned long long)t.tv_sec * 1000000 + (unsigned long long)t.tv_nsec / 1000;
}
