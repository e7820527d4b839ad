/* HTTP admission: any bytes on a connection to a whole service, without workers. Each reply has
 * a status that is meant; what an honest reading of the bytes finds ambiguous (two lengths, a
 * length and a coding, no Host, two Hosts, a blank before a colon) is refused, and no second
 * reply follows it, nor one to a head with a nameless line; and the service still answers
 * afterwards. What framing hands on of the same bytes does not depend on how they are cut. */
#include <microhttpd.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "check_threads.h"
#include "child.h"
#include "config.h"
#include "conns.h"
#include "error.h"
#include "folder.h"
#include "framing.h"
#include "fuzz.h"
#include "http.h"
#include "jobs.h"
#include "log.h"
#include "memory_cache.h"
#include "metrics.h"
#include "quota.h"
#include "run.h"
#include "service.h"
#include "store.h"

const char *const fuzz_words[] = { "GET ", "POST ", "DELETE ", "HEAD ", "PUT ", "/v1/jobs", "/v1/solve", "/v1/jobs/00000000000000000000000000000000",
    "/events", "/trajectory", "/healthz", "/metrics", "?limit=", "&cursor=1", "?format=csv", "?status=done,failed", "%00", "%2f", "../", " HTTP/1.1\r\n",
    " HTTP/1.0\r\n", "Host: localhost\r\n", "Host: evil.example\r\n", "Content-Length: 2\r\n", "Content-Length: 0\r\n", "Content-Length : 5\r\n",
    "Transfer-Encoding: chunked\r\n", "Transfer-Encoding: gzip\r\n", "\r\n\r\n", "\r\n", "\n", "Content-Type: application/json\r\n", "Connection: close\r\n",
    "Expect: 100-continue\r\n", "Prefer: wait=1\r\n", "If-None-Match: *\r\n", "Last-Event-ID: 3\r\n", "Accept: text/csv;q=0.1\r\n", "Origin: null\r\n",
    "Authorization: Bearer x\r\n", "traceparent: 00-00\r\n", "X-Request-Id: a\r\n", "0\r\n\r\n", "5\r\nhello\r\n", "5;a=\"b\"\r\nhello\r\n", "0\r\nA: b\r\n\r\n", "2\n{}", "{}", "{\"system\":{", NULL };

enum { REPLY_MS = 5000, REPLY_MOST = 1 << 20, ALIVE_EVERY = 64 };

static struct config config;
static struct metrics metrics;
static struct service service = { .config = &config, .metrics = &metrics };
static struct http *http;
static char folder[64], place[80];

static void suspend(void *connection) { MHD_suspend_connection(connection); }
static void resume(void *connection) { MHD_resume_connection(connection); }
static bool left(void *connection) { (void)connection; return false; }      /* nobody waits: --max-wait 0 */

/* Requests are checked by children, which are the same program. */
__attribute__((constructor)) static void be_child(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], CHILD_FLAG) == 0)
        _exit(child_main(argc, argv));
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static char listening[100], state[80];
    char *args[] = { "sgad", "--listen", listening, "--state", state, "--queue", "20", "--max-wait", "0", "--streams", "4", "--stream-timeout", "1",
                     "--body-limit", "4096", "--request-timeout", "4", "--send-timeout", "4", "--log-level", "error" };
    char why[512] = "";
    struct service *sv = &service;
    struct jobs_hooks hooks = { suspend, resume, left };
    (void)argc;
    (void)argv;
    signal(SIGPIPE, SIG_IGN);
    folder_make(folder, sizeof folder);
    snprintf(place, sizeof place, "%s/socket", folder);
    snprintf(listening, sizeof listening, "unix:%s", place);
    snprintf(state, sizeof state, "%s/state", folder);
    log_open(LOG_L_ERROR);
    sga_init();
    FUZZ_REQUIRE(config_read(sv->config, sizeof args / sizeof *args, args, why, sizeof why) == CONFIG_OK, "%s", why);
    bool ok = (sv->conns = conns_new()) && (sv->memory_cache = memory_cache_new((size_t)sv->config->cache_memory))
        && (sv->store = store_open(sv->config->state, 0, sv->metrics, why, sizeof why))
        && (store_limit(sv->store, &sv->config->cache_disk), true)
        && (sv->jobs = jobs_new(sv->config, sv->store, sv->memory_cache, sv->metrics, hooks))
        && (sv->everyone = jobs_account(sv->jobs, "", &(struct quota){ 0 })) && (sv->check_threads = check_threads_new(sv)) && (http = http_open(sv, why, sizeof why)) && http_start(http, why, sizeof why);
    FUZZ_REQUIRE(ok, "%s", why);
    return 0;
}

void fuzz_end(void)
{
    struct service *sv = &service;
    jobs_drain(sv->jobs);
    jobs_close_waiters(sv->jobs);
    check_threads_close(sv->check_threads);
    http_stop(http);
    check_threads_free(sv->check_threads);
    store_close(sv->store);
    jobs_free(sv->jobs);
    memory_cache_free(sv->memory_cache);
    conns_free(sv->conns);
    folder_empty(sv->config->state, 1);
    config_free(sv->config);
    folder_empty(folder, 1);
}

/* -- A client -- */

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Sends all, ends its side, and reads to the end. The length of what came; *closed: to the end. */
static size_t talk(const uint8_t *data, size_t size, char *reply, bool *closed)
{
    struct sockaddr_un a = { .sun_family = AF_UNIX };
    size_t sent = 0, got = 0;
    double until = now() + 1e-3 * REPLY_MS;
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    snprintf(a.sun_path, sizeof a.sun_path, "%s", place);
    FUZZ_REQUIRE(fd >= 0 && connect(fd, (struct sockaddr *)&a, sizeof a) == 0, "no connection");
    *closed = false;
    while (!*closed && now() < until) {
        struct pollfd p = { .fd = fd, .events = (short)(POLLIN | (sent < size ? POLLOUT : 0)) };
        poll(&p, 1, 100);
        if (p.revents & POLLOUT) {
            ssize_t n = send(fd, data + sent, size - sent, MSG_DONTWAIT | MSG_NOSIGNAL);
            sent = n > 0 ? sent + (size_t)n : size;
            if (sent == size)
                shutdown(fd, SHUT_WR);
        }
        if (p.revents & (POLLIN | POLLHUP | POLLERR)) {
            ssize_t n = recv(fd, reply + got, REPLY_MOST - 1 - got, MSG_DONTWAIT);
            *closed = n <= 0;
            got += n > 0 ? (size_t)n : 0;
        }
        if (size == 0)
            shutdown(fd, SHUT_WR);
    }
    close(fd);
    reply[got] = 0;
    return got;
}

/* -- An honest reading of the first request: only the lines, nothing of the library's -- */

enum reading { READ_UNKNOWN, READ_PLAIN, READ_ODD, READ_AMBIGUOUS };

static bool named(const char *line, size_t n, const char *name)
{
    size_t m = strlen(name);
    return n > m && line[m] == ':' && strncasecmp(line, name, m) == 0;
}

static enum reading read_head(const char *text, size_t size)
{
    int host = 0, length = 0, coding = 0, lines = 0;
    bool blank = false, nameless = false, http11 = false;
    const char *end = text + size;
    for (const char *line = text, *stop; line < end; line = stop + 1) {
        stop = memchr(line, '\n', (size_t)(end - line));
        if (!stop || stop == line || stop[-1] != '\r' || memchr(line, 0, (size_t)(stop - line)))
            return READ_UNKNOWN;             /* bare line feeds and zeros are the library's to judge */
        size_t n = (size_t)(stop - line) - 1;
        if (memchr(line, '\r', n))
            return READ_UNKNOWN;
        if (n == 0)
            return !lines ? READ_UNKNOWN : nameless ? READ_ODD : host != 1 || length > 1 || coding > 1 || (length && coding) || blank ? READ_AMBIGUOUS : READ_PLAIN;
        if (lines++ == 0) {
            http11 = n > 9 && memcmp(line + n - 9, " HTTP/1.1", 9) == 0;
            if (!http11)
                return READ_UNKNOWN;
            continue;
        }
        const char *colon = memchr(line, ':', n);
        if (!colon || *line == ' ' || *line == '\t')
            return READ_UNKNOWN;
        nameless |= colon == line;
        blank |= colon > line && (colon[-1] == ' ' || colon[-1] == '\t');
        host += named(line, n, "Host");
        length += named(line, n, "Content-Length");
        coding += named(line, n, "Transfer-Encoding");
    }
    return READ_UNKNOWN;
}

/* -- What must hold -- */

/* Framing, in one piece and byte by byte. */
static void check_cuts(const uint8_t *data, size_t size)
{
    struct framing whole, cut;
    struct sga_error err = { 0 }, cut_err = { 0 };
    size_t kept, out = 0, k = 0;
    char *text = malloc(2 * size + 1), *other = text + size;
    FUZZ_REQUIRE(text, "memory");
    memcpy(text, data, size);
    framing_init(&whole);
    framing_init(&cut);
    bool ok = framing_take(&whole, text, size, &kept, &err), cut_ok = true;
    for (size_t i = 0; i < size && cut_ok; i++, out += k) {
        other[out] = (char)data[i];
        cut_ok = framing_take(&cut, other + out, 1, &k, &cut_err);
    }
    FUZZ_REQUIRE(ok == cut_ok && kept == out && err.code == cut_err.code && whole.heads == cut.heads && memcmp(text, other, out) == 0, "cuts matter");
    free(text);
}

/* The statuses of all replies in the text: each begins a line. */
static int statuses(const char *text, int *first)
{
    static const int meant[] = { 200, 202, 304, 400, 403, 404, 405, 406, 409, 411, 413, 414, 415, 417, 422, 431, 501, 503, 505 };
    int count = 0;
    *first = 0;
    for (const char *p = text; (p = strstr(p, "HTTP/1.")); p++) {
        if (p[8] != ' ' || (p > text && p[-1] != '\n' && p[-1] != '}'))
            continue;                        /* not where a reply begins */
        int status = atoi(p + 9);
        size_t i = 0;
        if (status == 100)
            continue;
        while (i < sizeof meant / sizeof *meant && meant[i] != status)
            i++;
        FUZZ_REQUIRE(i < sizeof meant / sizeof *meant, "status %d in %.200s", status, p);
        if (!count++)
            *first = status;
    }
    return count;
}

static void check_alive(char *reply)
{
    static const char ask[] = "GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    bool closed;
    talk((const uint8_t *)ask, sizeof ask - 1, reply, &closed);
    FUZZ_REQUIRE(strncmp(reply, "HTTP/1.1 200", 12) == 0, "not alive: %.100s", reply);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char reply[REPLY_MOST];
    static unsigned runs;
    bool closed;
    int first;
    check_cuts(data, size);
    size_t got = talk(data, size, reply, &closed);
    for (size_t i = 0; i < got; i++)         /* bodies may hold zeros */
        if (!reply[i])
            reply[i] = '?';
    int count = statuses(reply, &first);
    enum reading as = read_head((const char *)data, size);
    if (as == READ_AMBIGUOUS || as == READ_ODD) {
        FUZZ_REQUIRE(count <= 1 && closed, "%d replies; closed: %d", count, closed);
        FUZZ_REQUIRE(as == READ_ODD || count == 0 || first >= 400, "an ambiguous request is answered with %d", first);
    }
    if (++runs % ALIVE_EVERY == 0)
        check_alive(reply);
    return 0;
}
