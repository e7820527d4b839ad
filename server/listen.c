/* The listening socket. Only loopback: there is neither encryption nor a check of who asks. */
#include "listen.h"

#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { BACKLOG = 512 };

static bool split(const char *address, char host[256], char port[8])
{
    const char *colon = strrchr(address, ':');
    if (!colon || !colon[1] || strlen(colon + 1) > 5 || strspn(colon + 1, "0123456789") != strlen(colon + 1) || atoi(colon + 1) > 65535)
        return false;
    size_t n = (size_t)(colon - address);
    if (n > 2 && address[0] == '[' && address[n - 1] == ']') {
        address++;
        n -= 2;
    }
    if (n == 0 || n > 255)
        return false;
    memcpy(host, address, n);
    host[n] = 0;
    strcpy(port, colon + 1);
    return true;
}

static bool is_loopback(const struct sockaddr *a)
{
    if (a->sa_family == AF_INET)
        return ntohl(((const struct sockaddr_in *)a)->sin_addr.s_addr) >> 24 == 127;
    return a->sa_family == AF_INET6 && IN6_IS_ADDR_LOOPBACK(&((const struct sockaddr_in6 *)a)->sin6_addr);
}

static int bind_to(const struct addrinfo *ai, int *port)
{
    int fd = socket(ai->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), yes = 1;
    if (fd < 0)
        return -1;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    struct sockaddr_storage bound;
    socklen_t length = sizeof bound;
    if (bind(fd, ai->ai_addr, ai->ai_addrlen) != 0 || listen(fd, BACKLOG) != 0
        || getsockname(fd, (struct sockaddr *)&bound, &length) != 0) {
        int saved = errno;
        close(fd);
        errno = saved;
        return -1;
    }
    *port = ntohs(bound.ss_family == AF_INET6 ? ((struct sockaddr_in6 *)&bound)->sin6_port : ((struct sockaddr_in *)&bound)->sin_port);
    return fd;
}

int listen_open(const char *address, int *port, char *why, size_t size)
{
    char host[256], service[8];
    struct addrinfo hints = { .ai_socktype = SOCK_STREAM, .ai_flags = AI_NUMERICHOST | AI_NUMERICSERV }, *ai = NULL;
    if (!split(address, host, service)) {
        snprintf(why, size, "--listen needs HOST:PORT with a port from 0 to 65535, not '%s'", address);
        return -1;
    }
    int rc = getaddrinfo(strcmp(host, "localhost") == 0 ? "127.0.0.1" : host, service, &hints, &ai);
    if (rc != 0) {
        snprintf(why, size, "--listen needs a numeric address, not '%s'", host);
        return -1;
    }
    int fd = -1;
    if (!is_loopback(ai->ai_addr))
        snprintf(why, size, "%s is no loopback address: without encryption and tokens sgad serves this machine only", host);
    else if ((fd = bind_to(ai, port)) < 0)
        snprintf(why, size, "cannot listen on %s: %s", address, strerror(errno));
    freeaddrinfo(ai);
    return fd;
}

void listen_host(const char *address, char *out, size_t size)
{
    const char *colon = strrchr(address, ':');
    int n = colon ? (int)(colon - address) : (int)strlen(address);
    bool bare = *address != '[' && memchr(address, ':', (size_t)n);
    snprintf(out, size, bare ? "[%.*s]" : "%.*s", n, address);
}
