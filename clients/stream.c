/* Sockets, and TLS by GnuTLS, which is also the daemon's. */
#include "interrupt.h"
#include "stream.h"

#include <arpa/inet.h>
#include <errno.h>
#include <gnutls/gnutls.h>
#include <netdb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

struct tls_session {
    gnutls_session_t session;
    gnutls_certificate_credentials_t trust;
};

static void be_patient(int fd, int patience)
{
    struct timeval limit = { .tv_sec = patience };
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
}

static int dial_unix(const char *path, char *why, size_t size)
{
    struct sockaddr_un a = { .sun_family = AF_UNIX };
    strcpy(a.sun_path, path);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (struct sockaddr *)&a, sizeof a) == 0)
        return fd;
    snprintf(why, size, "cannot connect to %s: %s", path, strerror(errno));
    if (fd >= 0)
        close(fd);
    return -1;
}

static int dial(const struct http_server *server, int patience, char *why, size_t size)
{
    struct addrinfo hints = { .ai_socktype = SOCK_STREAM }, *list;
    int rc = getaddrinfo(server->host, server->port, &hints, &list), fd = -1;
    if (rc != 0) {
        snprintf(why, size, "cannot find %s: %s", server->host, gai_strerror(rc));
        return -1;
    }
    for (struct addrinfo *ai = list; ai && fd < 0; ai = ai->ai_next) {
        fd = socket(ai->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
        be_patient(fd, patience);
        if (fd >= 0 && connect(fd, ai->ai_addr, ai->ai_addrlen) != 0) {
            snprintf(why, size, "cannot connect to %s port %s: %s", server->host, server->port, strerror(errno));
            close(fd);
            fd = -1;
        }
    }
    freeaddrinfo(list);
    return fd;
}

/* -- TLS -- */

static void forget(struct tls_session *t)
{
    if (t->session)
        gnutls_deinit(t->session);
    if (t->trust)
        gnutls_certificate_free_credentials(t->trust);
    free(t);
}

static bool is_address(const char *host)
{
    unsigned char room[16];
    return inet_pton(AF_INET, host, room) == 1 || inet_pton(AF_INET6, host, room) == 1;
}

/* How many certificates are trusted, or a negative GnuTLS code. */
static int trust(struct tls_session *t, const char *ca)
{
    int rc = gnutls_certificate_allocate_credentials(&t->trust);
    if (rc < 0)
        return rc;
    return ca ? gnutls_certificate_set_x509_trust_file(t->trust, ca, GNUTLS_X509_FMT_PEM) : gnutls_certificate_set_x509_system_trust(t->trust);
}

static int prepare(struct tls_session *t, const struct http_server *server, int fd)
{
    int rc = gnutls_init(&t->session, GNUTLS_CLIENT);
    if (rc >= 0)
        rc = gnutls_priority_set_direct(t->session, "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2", NULL);
    if (rc >= 0)
        rc = gnutls_credentials_set(t->session, GNUTLS_CRD_CERTIFICATE, t->trust);
    if (rc >= 0 && !is_address(server->host))
        rc = gnutls_server_name_set(t->session, GNUTLS_NAME_DNS, server->host, strlen(server->host));
    if (rc >= 0) {
        gnutls_session_set_verify_cert(t->session, server->host, 0);
        gnutls_transport_set_int(t->session, fd);
    }
    return rc;
}

static void explain(const struct tls_session *t, const struct http_server *server, int rc, char *why, size_t size)
{
    gnutls_datum_t text = { NULL, 0 };
    if (rc == GNUTLS_E_CERTIFICATE_VERIFICATION_ERROR)
        gnutls_certificate_verification_status_print(gnutls_session_get_verify_cert_status(t->session), GNUTLS_CRT_X509, &text, 0);
    snprintf(why, size, "no secure connection to %s port %s: %s", server->host, server->port, text.data ? (const char *)text.data : gnutls_strerror(rc));
    gnutls_free(text.data);
}

static struct tls_session *secure(const struct http_server *server, int fd, char *why, size_t size)
{
    struct tls_session *t = calloc(1, sizeof *t);
    if (!t) {
        snprintf(why, size, "out of memory");
        return NULL;
    }
    int rc = trust(t, server->ca);
    if (rc <= 0) {
        snprintf(why, size, "no trusted certificate could be read from %s%s%s", server->ca ? server->ca : "the system", rc < 0 ? ": " : "",
                 rc < 0 ? gnutls_strerror(rc) : "");
        forget(t);
        return NULL;
    }
    if ((rc = prepare(t, server, fd)) >= 0)
        do
            rc = gnutls_handshake(t->session);
        while (rc == GNUTLS_E_INTERRUPTED || rc == GNUTLS_E_WARNING_ALERT_RECEIVED);
    if (rc >= 0)
        return t;
    explain(t, server, rc, why, size);
    forget(t);
    return NULL;
}

/* -- Either -- */

bool stream_open(struct stream *s, const struct http_server *server, int patience, char *why, size_t size)
{
    *s = (struct stream){ .fd = *server->path ? dial_unix(server->path, why, size) : dial(server, patience, why, size) };
    if (s->fd < 0)
        return false;
    be_patient(s->fd, patience);
    if (!server->tls || (s->tls = secure(server, s->fd, why, size)))
        return true;
    close(s->fd);
    return false;
}

bool stream_send(struct stream *s, const char *data, size_t length)
{
    while (length) {
        ssize_t n = s->tls ? gnutls_record_send(s->tls->session, data, length) : send(s->fd, data, length, MSG_NOSIGNAL);
        if (s->tls && (n == GNUTLS_E_INTERRUPTED || n == GNUTLS_E_AGAIN))
            continue;
        if (n <= 0)
            return false;
        data += n;
        length -= (size_t)n;
    }
    return true;
}

/* A server that ends without saying so is the same as one that does: the length of the reply
 * tells whether it is whole. */
ssize_t stream_receive(struct stream *s, char *data, size_t size)
{
    for (;;) {
        ssize_t n = s->tls ? gnutls_record_recv(s->tls->session, data, size) : recv(s->fd, data, size, 0);
        if (s->tls && n == GNUTLS_E_PREMATURE_TERMINATION)
            return 0;
        if (interrupted() || (s->tls ? n != GNUTLS_E_INTERRUPTED : n >= 0 || errno != EINTR))
            return n < 0 && !s->tls && errno == ECONNRESET ? 0 : n;
    }
}

void stream_close(struct stream *s)
{
    if (s->tls) {
        gnutls_bye(s->tls->session, GNUTLS_SHUT_WR);
        forget(s->tls);
    }
    close(s->fd);
}
