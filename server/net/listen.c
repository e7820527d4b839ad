/* The listening sockets, and the rule about who may be let near them. */
#include "listen.h"
#include "config.h"
#include "inherit.h"

#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

enum { BACKLOG = 512, FIRST_PASSED = 3, SOCKET_MODE = 0660 };

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

static bool is_local(const struct sockaddr_storage *a)
{
    if (a->ss_family == AF_INET)
        return ntohl(((const struct sockaddr_in *)a)->sin_addr.s_addr) >> 24 == 127;
    if (a->ss_family == AF_INET6)
        return IN6_IS_ADDR_LOOPBACK(&((const struct sockaddr_in6 *)a)->sin6_addr);
    return a->ss_family == AF_UNIX;
}

/* Whoever reaches a socket off loopback is a stranger on a wire that others read. */
static bool allowed(const struct config *c, const struct sockaddr_storage *a, char *why, size_t size)
{
    bool plain = !c->tls_cert && !c->remote_plain, open = !config_tokens(c) && !c->remote_open;
    if (is_local(a) || (!plain && !open))
        return true;
    snprintf(why, size, "this is no loopback address: %s%s%s. Set %s%s%s, or say %s%s%s",
             plain ? "there is no encryption" : "", plain && open ? ", and " : "", open ? "everyone would be let in" : "",
             plain ? "tls-cert and tls-key" : "", plain && open ? " and " : "", open ? "access = tokens" : "",
             plain ? "--allow-remote-without-tls" : "", plain && open ? " and " : "", open ? "--allow-remote-without-tokens" : "");
    return false;
}

static void describe(const struct config *c, const struct sockaddr_storage *a, struct listening *out)
{
    char host[256] = "", port[8] = "";
    const char *scheme = c->tls_cert ? "https" : "http";
    if (a->ss_family == AF_UNIX) {
        snprintf(out->url, sizeof out->url, "unix:%.107s", ((const struct sockaddr_un *)a)->sun_path);
        out->local = true;
        return;
    }
    socklen_t length = a->ss_family == AF_INET ? sizeof(struct sockaddr_in) : sizeof(struct sockaddr_in6);
    getnameinfo((const struct sockaddr *)a, length, host, sizeof host, port, sizeof port, NI_NUMERICHOST | NI_NUMERICSERV);
    snprintf(out->host, sizeof out->host, a->ss_family == AF_INET6 ? "[%s]" : "%s", host);
    snprintf(out->url, sizeof out->url, "%s://%s:%s", scheme, out->host, port);
}

static bool fail(int fd, const char *address, char *why, size_t size)
{
    snprintf(why, size, "cannot listen on %s: %s", address, strerror(errno));
    if (fd >= 0)
        close(fd);
    return false;
}

/* Checks a socket that is bound already, makes it listen, and describes it. */
static bool finish(const struct config *c, int fd, bool bound_here, struct listening *out, char *why, size_t size)
{
    struct sockaddr_storage a = { 0 };
    socklen_t length = sizeof a;
    if (getsockname(fd, (struct sockaddr *)&a, &length) != 0 || (bound_here && listen(fd, BACKLOG) != 0))
        return fail(fd, out->address, why, size);
    if (!allowed(c, &a, why, size)) {
        close(fd);
        return false;
    }
    describe(c, &a, out);
    out->fd = fd;
    return true;
}

static bool open_tcp(const struct config *c, const char *address, struct listening *out, char *why, size_t size)
{
    char host[256], service[8];
    struct addrinfo hints = { .ai_socktype = SOCK_STREAM, .ai_flags = AI_NUMERICHOST | AI_NUMERICSERV }, *ai = NULL;
    if (!split(address, host, service)) {
        snprintf(why, size, "--listen needs HOST:PORT with a port from 0 to 65535, unix:PATH or systemd, not '%s'", address);
        return false;
    }
    if (getaddrinfo(strcmp(host, "localhost") == 0 ? "127.0.0.1" : host, service, &hints, &ai) != 0) {
        snprintf(why, size, "--listen needs a numeric address, not '%s'", host);
        return false;
    }
    struct sockaddr_storage a = { 0 };
    memcpy(&a, ai->ai_addr, ai->ai_addrlen);
    socklen_t length = ai->ai_addrlen;
    freeaddrinfo(ai);
    if (!allowed(c, &a, why, size))
        return false;
    int fd = socket(a.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), yes = 1;
    if (fd >= 0)
        setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (fd < 0 || bind(fd, (struct sockaddr *)&a, length) != 0)
        return fail(fd, address, why, size);
    return finish(c, fd, true, out, why, size);
}

/* The name of a socket that nobody listens on any more stands in the way; it is removed. A
 * file of any other kind, or a socket that answers, is not touched. */
static void remove_stale(const struct sockaddr_un *a)
{
    struct stat st;
    if (lstat(a->sun_path, &st) != 0 || !S_ISSOCK(st.st_mode))
        return;
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)a, sizeof *a) != 0 && errno == ECONNREFUSED)
        unlink(a->sun_path);
    if (fd >= 0)
        close(fd);
}

static bool open_unix(const struct config *c, const char *address, struct listening *out, char *why, size_t size)
{
    const char *path = address + 5;
    struct sockaddr_un a = { .sun_family = AF_UNIX };
    if (*path != '/' || strlen(path) >= sizeof a.sun_path) {
        snprintf(why, size, "--listen unix:PATH needs an absolute path of less than %zu characters", sizeof a.sun_path);
        return false;
    }
    strcpy(a.sun_path, path);
    remove_stale(&a);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    /* The mode is set before anyone can connect: nobody can until it listens. */
    if (fd < 0 || bind(fd, (struct sockaddr *)&a, sizeof a) != 0)
        return fail(fd, address, why, size);
    strcpy(out->path, path);
    if (chmod(path, SOCKET_MODE) != 0)
        return fail(fd, address, why, size);
    return finish(c, fd, true, out, why, size);
}

/* The protocol of sd_listen_fds(3): descriptors from 3 on, LISTEN_FDS of them, for the
 * process LISTEN_PID. The variables stay: settings that are read again find them as before, and
 * children get an environment of their own. */
static bool open_passed(const struct config *c, struct listening *out, char *why, size_t size)
{
    const char *pid = getenv("LISTEN_PID"), *count = getenv("LISTEN_FDS");
    int listens = 0;
    socklen_t length = sizeof listens;
    if (!pid || !count || strtol(pid, NULL, 10) != (long)getpid())
        snprintf(why, size, "--listen systemd: no socket was passed to this process (LISTEN_PID, LISTEN_FDS)");
    else if (strcmp(count, "1") != 0)
        snprintf(why, size, "--listen systemd: one socket is served, not %.20s", count);
    else if (getsockopt(FIRST_PASSED, SOL_SOCKET, SO_ACCEPTCONN, &listens, &length) != 0 || !listens)
        snprintf(why, size, "--listen systemd: what was passed is no listening stream socket");
    else
        return finish(c, FIRST_PASSED, false, out, why, size);
    return false;
}

static bool open_one(const struct config *c, const char *address, struct listening *out, char *why, size_t size)
{
    *out = (struct listening){ .fd = -1 };
    snprintf(out->address, sizeof out->address, "%s", address);
    int fd = inherit_take(address);
    if (fd >= 0) {
        snprintf(out->path, sizeof out->path, "%s", strncmp(address, "unix:", 5) == 0 ? address + 5 : "");
        return finish(c, fd, false, out, why, size);
    }
    if (strncmp(address, "unix:", 5) == 0)
        return open_unix(c, address, out, why, size);
    if (strcmp(address, "systemd") == 0)
        return open_passed(c, out, why, size);
    return open_tcp(c, address, out, why, size);
}

bool listen_open(const struct config *c, struct listeners *out, char *why, size_t size)
{
    out->count = 0;
    for (const char *p = c->listen; *p;) {
        char address[sizeof out->at->address];
        size_t n = strcspn(p, ",");
        if (n == 0 || n >= sizeof address || out->count == LISTEN_MOST) {
            snprintf(why, size, "--listen takes 1 to %d addresses, separated by single commas", LISTEN_MOST);
            return false;
        }
        memcpy(address, p, n);
        address[n] = 0;
        if (!open_one(c, address, &out->at[out->count++], why, size))
            return false;
        p += n + (p[n] == ',' && p[n + 1]);
    }
    return out->count > 0;
}

void listen_close(struct listeners *ls)
{
    for (int i = 0; i < ls->count; i++) {
        if (ls->at[i].fd >= 0)
            close(ls->at[i].fd);
        if (*ls->at[i].path)
            unlink(ls->at[i].path);
    }
    ls->count = 0;
}
