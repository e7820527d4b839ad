/* As many requests as a server answers: hammer PORT FILE SECONDS
 *
 * FILE is one HTTP request as bytes. It is sent over and over on a few connections that are kept
 * alive, the next one once the reply has come. Prints the number of replies and the seconds;
 * a reply whose status is not 200 ends it with 1. */
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { CONNECTIONS = 16, MOST = 1 << 18 };

struct connection {
    char in[MOST];
    size_t got;
};

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int dial(int port)
{
    struct sockaddr_in a = { .sin_family = AF_INET, .sin_port = htons((unsigned short)port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK) };
    int fd = socket(AF_INET, SOCK_STREAM, 0), on = 1;
    if (fd < 0 || connect(fd, (struct sockaddr *)&a, sizeof a) != 0)
        return -1;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return fd;
}

/* 1 once a whole reply is there, -1 where it is not a good one. */
static int whole(struct connection *c)
{
    c->in[c->got] = 0;
    const char *end = strstr(c->in, "\r\n\r\n"), *length = strstr(c->in, "\r\nContent-Length: ");
    if (!end)
        return 0;
    if (strncmp(c->in, "HTTP/1.1 200", 12) != 0 || !length || length > end)
        return -1;
    return c->got >= (size_t)(end + 4 - c->in) + strtoul(length + 18, NULL, 10);
}

int main(int argc, char **argv)
{
    static struct connection connection[CONNECTIONS];
    static char request[MOST];
    struct pollfd p[CONNECTIONS];
    FILE *f = argc == 4 ? fopen(argv[2], "rb") : NULL;
    size_t length = f ? fread(request, 1, sizeof request, f) : 0;
    if (!length) {
        fprintf(stderr, "usage: hammer PORT FILE SECONDS\n");
        return 2;
    }
    fclose(f);
    for (int i = 0; i < CONNECTIONS; i++) {
        p[i] = (struct pollfd){ .fd = dial(atoi(argv[1])), .events = POLLIN };
        if (p[i].fd < 0 || send(p[i].fd, request, length, 0) != (ssize_t)length)
            return 1;
    }
    unsigned long replies = 0;
    double begun = now(), until = begun + atof(argv[3]);
    while (now() < until) {
        poll(p, CONNECTIONS, 1000);
        for (int i = 0; i < CONNECTIONS; i++) {
            struct connection *c = &connection[i];
            if (!p[i].revents)
                continue;
            ssize_t n = recv(p[i].fd, c->in + c->got, MOST - 1 - c->got, 0);
            if (n <= 0)
                return 1;
            c->got += (size_t)n;
            int state = whole(c);
            if (state < 0)
                return 1;
            if (state > 0) {
                c->got = 0;
                replies++;
                send(p[i].fd, request, length, 0);
            }
        }
    }
    printf("%lu %.6f\n", replies, now() - begun);
    return 0;
}
