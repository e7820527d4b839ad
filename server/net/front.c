/* Requests that are refused. All bytes before the fault were judged good; those of whole requests are handed on and answered
 * first. Only then, when the library asks for more, comes the refusal. That it asks although nothing more may come is made
 * sure by an end of the stream of our own (SHUT_RD: readable for ever).
 *
 * A client that still writes while its refusal is under way must not get a reset for it, which would take the refusal away from
 * it: our side ends, and what comes is read and dropped until its side ends, or the connection's deadline cuts it. */
#include "front.h"
#include "error.h"
#include "framing.h"

#include <assert.h>
#include <dlfcn.h>
#include <errno.h>
#include <gnutls/gnutls.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/socket.h>

struct front {
    struct conn *conn;
    gnutls_session_t session;
    int fd;
    bool secure, refused, last, gone;      /* last: no byte after what was handed on counts; gone: our side has ended */
    struct framing framing;
    unsigned long begun, answered;
    struct sga_error err;
};

enum { DESCRIPTORS_MOST = 1 << 20, DROPS_MOST = 64 };

/* Whole once it is seen: other threads call recv() before and while the front starts. */
struct fronts {
    size_t n;
    _Atomic(struct front *) by_fd[];
};

static _Atomic(struct fronts *) fronts;
static front_refuse *refuse;
static void *refuse_cls;
static ssize_t (*library_record_recv)(gnutls_session_t, void *, size_t);

__attribute__((visibility("default"))) ssize_t recv(int fd, void *buf, size_t n, int flags);
__attribute__((visibility("default"))) ssize_t gnutls_record_recv(gnutls_session_t session, void *data, size_t n);

static struct fronts *fronts_new(void)
{
    struct rlimit r;
    size_t n = getrlimit(RLIMIT_NOFILE, &r) == 0 && r.rlim_cur < DESCRIPTORS_MOST ? (size_t)r.rlim_cur : DESCRIPTORS_MOST;
    struct fronts *all = calloc(1, sizeof *all + n * sizeof all->by_fd[0]);
    if (all)
        all->n = n;
    return all;
}

bool front_start(front_refuse *how, void *cls, char *why, size_t size)
{
    *(void **)&library_record_recv = dlsym(RTLD_NEXT, "gnutls_record_recv");
    if (dlsym(RTLD_DEFAULT, "recv") != (void *)(size_t)recv || dlsym(RTLD_DEFAULT, "gnutls_record_recv") != (void *)(size_t)gnutls_record_recv
        || !library_record_recv) {
        snprintf(why, size, "the HTTP library would read past the front");
        return false;
    }
    refuse = how;
    refuse_cls = cls;
    if (!atomic_load(&fronts))
        atomic_store(&fronts, fronts_new());
    if (!atomic_load(&fronts))
        snprintf(why, size, "out of memory");
    return atomic_load(&fronts) != NULL;
}

/* The place of a descriptor; NULL before the front starts and for numbers that no connection has. */
static _Atomic(struct front *) *place(int fd)
{
    struct fronts *all = atomic_load_explicit(&fronts, memory_order_acquire);
    return all && fd >= 0 && (size_t)fd < all->n ? &all->by_fd[fd] : NULL;
}

struct front *front_open(int fd, void *session, struct conn *conn)
{
    _Atomic(struct front *) *at = place(fd);
    struct front *f = at ? calloc(1, sizeof *f) : NULL;
    if (!f)
        return NULL;
    f->conn = conn;
    f->fd = fd;
    f->session = session;
    f->secure = session != NULL;
    framing_init(&f->framing);
    struct front *before = atomic_exchange(at, f);
    assert(!before);                         /* a descriptor is closed after its front */
    return f;
}

void front_close(struct front *f)
{
    if (!f)
        return;
    struct front *mine = atomic_exchange(place(f->fd), NULL);
    assert(mine == f);
    free(f);
}

bool front_begin(struct front *f)
{
    return f && ++f->begun <= f->framing.heads;
}

void front_answered(struct front *f)
{
    if (f && f->answered < f->begun)
        f->answered = f->begun;
}

bool front_refused(const struct front *f)
{
    return f && f->gone;
}

static struct front *front_of(int fd)
{
    _Atomic(struct front *) *at = place(fd);
    return at ? atomic_load_explicit(at, memory_order_acquire) : NULL;
}

/* -- Bytes, with encryption or without: as recv() says it, errno included -- */

static ssize_t get(struct front *f, gnutls_session_t session, void *buf, size_t n, int flags)
{
    return f->secure ? library_record_recv(session, buf, n) : recvfrom(f->fd, buf, n, flags, NULL, NULL);
}

static void say(struct front *f, gnutls_session_t session, const char *reply, size_t n)
{
    ssize_t rc = 0;
    if (n)
        rc = f->secure ? gnutls_record_send(session, reply, n) : send(f->fd, reply, n, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (rc >= 0 && f->secure)
        gnutls_bye(session, GNUTLS_SHUT_WR);
    shutdown(f->fd, SHUT_WR);
}

static ssize_t again(const struct front *f)
{
    errno = EAGAIN;
    return f->secure ? GNUTLS_E_AGAIN : -1;
}

/* As if the client had gone: the library closes without a word of its own. */
static ssize_t gone(const struct front *f)
{
    errno = ECONNRESET;
    return f->secure ? GNUTLS_E_PREMATURE_TERMINATION : -1;
}

/* Until nothing more is there: again(); until the client's side has ended: gone(). */
static ssize_t drop(struct front *f, gnutls_session_t session)
{
    char waste[4096];
    ssize_t n = 1;
    for (int i = 0; i < DROPS_MOST && n > 0; i++)
        n = get(f, session, waste, sizeof waste, MSG_DONTWAIT);
    bool waits = f->secure ? n == GNUTLS_E_AGAIN || n == GNUTLS_E_INTERRUPTED : n < 0 && (errno == EAGAIN || errno == EINTR);
    return (n > 0 || waits) && !f->last ? again(f) : gone(f);
}

/* The refusal, now that it is its turn. */
static ssize_t turn_away(struct front *f, gnutls_session_t session, bool unanswered)
{
    char reply[FRONT_REPLY];
    assert(f->refused && !f->gone && f->err.code != SGA_E_OK);      /* one refusal for each connection */
    f->gone = true;
    if (!unanswered)
        return gone(f);
    say(f, session, reply, refuse(refuse_cls, f->conn, f->fd, f->framing.head_request, &f->err, reply));
    return drop(f, session);
}

/* Requests before the one at fault. */
static unsigned long before(const struct front *f)
{
    return f->framing.heads - !framing_in_head(&f->framing);
}

/* What came, judged: how much is handed on. */
static ssize_t judge(struct front *f, gnutls_session_t session, char *buf, size_t n)
{
    size_t kept;
    assert(!f->refused);
    if (framing_take(&f->framing, buf, n, &kept, &f->err))
        return kept ? (ssize_t)kept : again(f);
    f->refused = true;
    if (f->answered >= before(f))
        return turn_away(f, session, f->answered == before(f));
    f->last = true;
    shutdown(f->fd, SHUT_RD);
    return kept ? (ssize_t)kept : again(f);
}

static ssize_t take(struct front *f, gnutls_session_t session, void *buf, size_t n, int flags)
{
    if (f->gone)
        return drop(f, session);
    if (f->refused)
        return turn_away(f, session, f->answered == before(f));
    for (;;) {
        ssize_t got = get(f, session, buf, n, flags);
        if (got <= 0)
            return got;
        ssize_t kept = judge(f, session, buf, (size_t)got);
        if (kept > 0 || f->refused)
            return kept;          /* else all of it was taken out: is there more? */
    }
}

ssize_t recv(int fd, void *buf, size_t n, int flags)
{
    struct front *f = front_of(fd);
    return !f || f->secure ? recvfrom(fd, buf, n, flags, NULL, NULL) : take(f, NULL, buf, n, flags);
}

ssize_t gnutls_record_recv(gnutls_session_t session, void *data, size_t n)
{
    struct front *f = front_of(gnutls_transport_get_int(session));
    if (!library_record_recv)
        *(void **)&library_record_recv = dlsym(RTLD_NEXT, "gnutls_record_recv");
    return f && f->session == session ? take(f, session, data, n, 0) : library_record_recv(session, data, n);
}
