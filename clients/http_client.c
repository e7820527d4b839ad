/* One exchange is one handle of libcurl's: made, used, dropped. */
#include "http_client.h"

#include <stdio.h>
#include <string.h>

#include "interrupt.h"
#include "libcurl.h"

enum {
    PATIENCE = 60,            /* seconds of silence past the wait that was asked for */
    MOST_LINE = 1 << 20,      /* bytes; longer lines are no events of a daemon's */
};

/* Where a reply goes while it comes. */
struct taker {
    CURL *curl;
    struct http_reply *reply;
    struct sga_buf text;      /* the line so far */
    bool (*line)(void *ctx, const char *text);      /* NULL: the body is taken whole */
    void *ctx;
    bool enough;              /* `line` said so */
    bool before;              /* an interrupt came before this exchange, which is what follows from it */
};

static long status_of(CURL *curl)
{
    long status = 0;
    libcurl.easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
    return status;
}

/* False: the caller has enough, or the line is too long. */
static bool take_lines(struct taker *t, const char *s, size_t n)
{
    while (n) {
        const char *end = memchr(s, '\n', n);
        size_t part = end ? (size_t)(end - s) : n;
        sga_buf_put(&t->text, s, part);
        if (t->text.len >= MOST_LINE)
            return false;
        if (!end)
            return true;
        t->enough = !t->line(t->ctx, t->text.len ? t->text.data : "");
        sga_buf_clear(&t->text);
        if (t->enough)
            return false;
        s = end + 1;
        n -= part + 1;
    }
    return true;
}

static size_t take(char *data, size_t one, size_t n, void *ctx)
{
    struct taker *t = ctx;
    if (t->line && status_of(t->curl) == 200)
        return take_lines(t, data, one * n) ? one * n : 0;
    sga_buf_put(&t->reply->body, data, one * n);
    return one * n;
}

static int watch(void *ctx, curl_off_t down, curl_off_t got, curl_off_t up, curl_off_t sent)
{
    const struct taker *t = ctx;
    (void)down, (void)got, (void)up, (void)sent;
    return interrupted() && !t->before;
}

static struct curl_slist *headers(const struct http_server *server, bool body, int wait)
{
    char prefer[64];
    struct sga_buf token = { 0 };
    snprintf(prefer, sizeof prefer, "Prefer: wait=%d", wait);
    struct curl_slist *list = libcurl.slist_append(libcurl.slist_append(libcurl.slist_append(NULL, "Accept: application/json"), "Expect:"), prefer);
    if (body)
        list = libcurl.slist_append(list, "Content-Type: application/json");
    if (server->token) {
        sga_buf_printf(&token, "Authorization: Bearer %s", server->token);
        list = libcurl.slist_append(list, token.data);
    }
    sga_buf_free(&token);
    return list;
}

static void prepare(CURL *c, const struct http_server *server, int wait)
{
    libcurl.easy_setopt(c, CURLOPT_USERAGENT, "sga");
    libcurl.easy_setopt(c, CURLOPT_PROTOCOLS_STR, "http,https");
    libcurl.easy_setopt(c, CURLOPT_PATH_AS_IS, 1L);
    libcurl.easy_setopt(c, CURLOPT_ACCEPT_ENCODING, "");       /* what it can unpack */
    libcurl.easy_setopt(c, CURLOPT_CONNECTTIMEOUT, (long)PATIENCE);
    libcurl.easy_setopt(c, CURLOPT_LOW_SPEED_LIMIT, 1L);
    libcurl.easy_setopt(c, CURLOPT_LOW_SPEED_TIME, (long)(wait + PATIENCE));
    libcurl.easy_setopt(c, CURLOPT_SSLVERSION, (long)CURL_SSLVERSION_TLSv1_2);
    if (*server->socket)
        libcurl.easy_setopt(c, CURLOPT_UNIX_SOCKET_PATH, server->socket);
    if (server->here)
        libcurl.easy_setopt(c, CURLOPT_PROXY, "");             /* whatever the environment names */
    if (server->ca) {
        libcurl.easy_setopt(c, CURLOPT_CAINFO, server->ca);
        libcurl.easy_setopt(c, CURLOPT_CAPATH, NULL);
    }
}

/* What libcurl says, after what it was about. */
static void explain(CURL *c, CURLcode code, const char *said, const struct http_server *server, char *why, size_t size)
{
    long number = 0;
    const char *detail = *said ? said : libcurl.easy_strerror(code);
    libcurl.easy_getinfo(c, CURLINFO_OS_ERRNO, &number);
    switch (code) {
    case CURLE_COULDNT_RESOLVE_HOST:
        snprintf(why, size, "cannot find %s: %s", server->name, detail);
        break;
    case CURLE_COULDNT_RESOLVE_PROXY:
        snprintf(why, size, "cannot find the proxy: %s", detail);
        break;
    case CURLE_COULDNT_CONNECT:
        snprintf(why, size, "cannot connect to %s: %s", server->name, number ? strerror((int)number) : detail);
        break;
    case CURLE_SSL_CACERT_BADFILE:
        snprintf(why, size, "no trusted certificate could be read from %s", server->ca ? server->ca : "the system");
        break;
    case CURLE_SSL_CONNECT_ERROR:
    case CURLE_PEER_FAILED_VERIFICATION:
        snprintf(why, size, "no secure connection to %s: %s", server->name, detail);
        break;
    default:
        snprintf(why, size, "%s gave no whole reply: %s", server->name, detail);
    }
}

static void take_location(CURL *c, struct http_reply *reply)
{
    struct curl_header *h;
    if (libcurl.easy_header(c, "Location", 0, CURLH_HEADER, -1, &h) == CURLHE_OK)
        snprintf(reply->location, sizeof reply->location, "%s", h->value);
}

static bool exchange(const struct http_server *server, const char *method, const char *path, const char *body, size_t length, int wait,
                     struct taker *t, char *why, size_t size)
{
    char said[CURL_ERROR_SIZE] = "";
    struct sga_buf url = { 0 };
    *t->reply = (struct http_reply){ 0 };
    /* Off this machine a token goes over TLS only. */
    if (server->token && !server->tls && !server->here) {
        snprintf(why, size, "a token is not sent to %s without encryption; use https://, or unset SGA_TOKEN", server->name);
        return false;
    }
    if (!libcurl_load()) {
        snprintf(why, size, "libcurl is not installed, by which a server is asked (Debian's package libcurl3-gnutls); leave --server out to solve here");
        return false;
    }
    CURL *c = t->curl = libcurl.easy_init();
    if (!c) {
        snprintf(why, size, "out of memory");
        return false;
    }
    struct curl_slist *list = headers(server, body != NULL, wait);
    sga_buf_printf(&url, "%s%s", server->url, path);
    prepare(c, server, wait);
    libcurl.easy_setopt(c, CURLOPT_URL, url.data);
    libcurl.easy_setopt(c, CURLOPT_HTTPHEADER, list);
    libcurl.easy_setopt(c, CURLOPT_ERRORBUFFER, said);
    libcurl.easy_setopt(c, CURLOPT_WRITEFUNCTION, take);
    libcurl.easy_setopt(c, CURLOPT_WRITEDATA, t);
    libcurl.easy_setopt(c, CURLOPT_XFERINFOFUNCTION, watch);
    libcurl.easy_setopt(c, CURLOPT_XFERINFODATA, t);
    libcurl.easy_setopt(c, CURLOPT_NOPROGRESS, 0L);
    if (body) {
        libcurl.easy_setopt(c, CURLOPT_POSTFIELDSIZE_LARGE, (curl_off_t)length);
        libcurl.easy_setopt(c, CURLOPT_POSTFIELDS, body);
    }
    libcurl.easy_setopt(c, CURLOPT_CUSTOMREQUEST, method);
    t->before = body || interrupted();      /* what was posted may have begun something, whose name is to be known */
    CURLcode code = libcurl.easy_perform(c);
    bool ok = code == CURLE_OK || t->enough;
    t->reply->status = (int)status_of(c);
    take_location(c, t->reply);
    if (!ok)
        explain(c, code, said, server, why, size);
    libcurl.easy_cleanup(c);
    libcurl.slist_free_all(list);
    sga_buf_free(&url);
    return ok;
}

bool http_ask(const struct http_server *server, const char *method, const char *path, const char *body, size_t length,
              int wait, struct http_reply *reply, char *why, size_t size)
{
    struct taker t = { .reply = reply };
    bool ok = exchange(server, method, path, body, length, wait, &t, why, size);
    if (!ok)
        sga_buf_free(&reply->body);
    return ok;
}

bool http_lines(const struct http_server *server, const char *path, bool (*line)(void *ctx, const char *text), void *ctx,
                struct http_reply *reply, char *why, size_t size)
{
    struct taker t = { .reply = reply, .line = line, .ctx = ctx };
    bool ok = exchange(server, "GET", path, NULL, 0, 0, &t, why, size);
    sga_buf_free(&t.text);
    return ok;
}
